"""One stream for all plans of a batch: their own streams, joined as events come.

An event's id holds how much of every plan's stream has been sent, so that a client that comes back
gets exactly the rest, from whichever server. Streams that were sent to their ends are told apart
from numbers, and runs of equal entries are counted, so ids stay short:
`e*200.7.12.1*54` is two hundred plans to their ends, two after events 7 and 12, 54 after event 1.
"""

import asyncio
import logging
import re
from collections.abc import AsyncIterator, Sequence
from itertools import groupby

from fastapi.sse import ServerSentEvent

from service.api.event_stream import data_of
from service.jobs.job import BatchMember, LoggedEvent
from service.jobs.service import JobService

# How many events wait for a slow client.
_MOST_PENDING = 64
_LONGEST_ID = 4000
_ENTRY = re.compile(r"(e|[0-9]{1,9})(?:\*([1-9][0-9]{0,3}))?")
_log = logging.getLogger(__name__)

# Of the last event of each stream that was sent; None if that was the last one of all.
type Positions = list[int | None]


def id_of(positions: Positions) -> str:
    """Return the id of the event after which streams are at these positions."""
    runs = [
        ("e" if seen is None else str(seen), len(list(same))) for seen, same in groupby(positions)
    ]
    return ".".join(entry if count == 1 else f"{entry}*{count}" for entry, count in runs)


def positions_of(identifier: str | None, count: int) -> Positions:
    """Return the positions that an id holds; all at the beginning if it is not of such a stream."""
    positions: Positions = []
    for part in (identifier or "")[:_LONGEST_ID].split("."):
        found = _ENTRY.fullmatch(part)
        if found is None or len(positions) > count:
            break
        entry = None if found[1] == "e" else int(found[1])
        positions += [entry] * int(found[2] or 1)
    return positions if len(positions) == count else [0] * count


async def batch_events(
    jobs: JobService, members: Sequence[BatchMember], last_event_id: str | None
) -> AsyncIterator[ServerSentEvent]:
    """Yield what happened to the plans of a batch after an event, and what happens to the end."""
    positions = positions_of(last_event_id, len(members))
    async for k, event in _joined(jobs, members, positions):
        positions[k] = None if event.is_last else event.number
        data = {"plan": event.job, **data_of(event)}
        yield ServerSentEvent(id=id_of(positions), event=event.type, data=data)


async def _joined(
    jobs: JobService, members: Sequence[BatchMember], positions: Positions
) -> AsyncIterator[tuple[int, LoggedEvent]]:
    """Yield events with the number of their plan; those of a plan in their order."""
    pending: asyncio.Queue[tuple[int, LoggedEvent | None]] = asyncio.Queue(_MOST_PENDING)

    async def follow(k: int, after: int) -> None:
        try:
            async for event in jobs.events(members[k], after):
                await pending.put((k, event))
        except Exception:  # noqa: BLE001  (one that was deleted meanwhile; the others go on)
            _log.exception("the events of %s could not be read", members[k].id)
        await pending.put((k, None))

    loop = asyncio.get_running_loop()
    left = [(k, seen) for k, seen in enumerate(positions) if seen is not None]
    tasks = [loop.create_task(follow(k, seen)) for k, seen in left]
    num_open = len(tasks)
    try:
        while num_open:
            k, event = await pending.get()
            if event is None:
                num_open -= 1
            else:
                yield k, event
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
