"""EventBuffer: the events of a run, recorded in order, then published."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from service.jobs.errors import DatabaseTaken
from service.jobs.job import PendingEvent
from service.jobs.json_text import Encoded
from service.jobs.store.sql.database import is_of_database

_MAX_BACKLOG = 256
# Events that come so soon after another one are recorded with it [s]. A quick plan has ended by
# then, and its end takes them along: it does not wait for a transaction of theirs.
_GATHERING = 0.025
# Before a database that took nothing is asked again [s].
_PAUSE = 1.0
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Event:
    type: str
    data: Encoded
    is_update: bool


class EventBuffer:
    """Takes events at any pace and records what has gathered while the database was busy.

    Attributes:
        latest: The last event of each type, recorded or not.
        is_refused: Whether the database refused the last events.
    """

    def __init__(self, record: Callable[[Sequence[PendingEvent]], Awaitable[None]]) -> None:
        """Record, and publish, by awaiting `record`."""
        self.latest: dict[str, Encoded] = {}
        self.is_refused = False
        self._record = record
        self._backlog: list[_Event] = []
        self._gathering: asyncio.TimerHandle | None = None
        self._writing: asyncio.Task[None] | None = None
        self._flushes: list[asyncio.Future[None]] = []
        self._is_closed = False
        self._is_urgent = asyncio.Event()
        self._has_space = asyncio.Event()
        self._has_space.set()

    def put(self, event_type: str, data: Encoded, *, is_update: bool = False) -> None:
        """Take an event; after `close` it is dropped.

        Args:
            event_type: Of the event.
            data: JSON.
            is_update: Whether it may replace the one before it if that is of its type and there is
                much to record.
        """
        if self._is_closed:
            return
        self.latest[event_type[:64]] = data
        self._backlog.append(_Event(event_type[:64], data, is_update))
        self._bound()
        if self._writing is None and self._gathering is None:
            loop = asyncio.get_running_loop()
            self._gathering = loop.call_later(_GATHERING, self._begin_to_write)

    async def wait_for_space(self) -> None:
        """Wait while there is much to record."""
        await self._has_space.wait()

    async def flush(self) -> None:
        """Record at once what was taken so far, so that what is recorded next comes after it.

        It ends as well where the database refuses events.
        """
        if self._gathering is not None:
            self._gathering.cancel()
            self._begin_to_write()
        if self._writing is None or self.is_refused:
            return
        flushed = asyncio.get_running_loop().create_future()
        self._flushes.append(flushed)
        self._is_urgent.set()
        await flushed

    async def close(self) -> list[PendingEvent]:
        """Take no more, wait for what is being recorded, and return what is not recorded."""
        self._is_closed = True
        self._is_urgent.set()
        if self._gathering is not None:
            self._gathering.cancel()
        if self._writing is not None:
            await self._writing
        return [(event.type, event.data) for event in self._backlog]

    def _begin_to_write(self) -> None:
        self._gathering = None
        self._writing = asyncio.get_running_loop().create_task(self._write())

    async def _write(self) -> None:
        while self._backlog and not self._is_closed:
            events, self._backlog = self._backlog, []
            flushes, self._flushes = self._flushes, []
            self._is_urgent.clear()
            self._has_space.set()
            try:
                await self._record([(event.type, event.data) for event in events])
                self.is_refused = False
            except DatabaseTaken:
                pass
            except Exception as fault:  # noqa: BLE001  (the job itself goes on)
                if is_of_database(fault):
                    self._take_back(events)
                else:
                    _log.exception("%d events were lost", len(events))
            _end(flushes)
            await self._gather(_PAUSE if self.is_refused else _GATHERING)
        self._writing = None
        _end(self._flushes)
        self._flushes = []

    def _take_back(self, events: list[_Event]) -> None:
        """Hold events that the database does not take just now."""
        self.is_refused = True
        self._backlog = events + self._backlog
        self._bound()

    async def _gather(self, seconds: float) -> None:
        """Let events gather for a while, or until what has gathered shall be recorded."""
        with suppress(TimeoutError):
            await asyncio.wait_for(self._is_urgent.wait(), seconds)

    def _bound(self) -> None:
        """Hold no more than there is room for.

        Every other update gives way to the one that follows it. A task waits while the database is
        slow, but it is not held up by one that takes nothing: then the oldest events are lost.
        """
        if len(self._backlog) < _MAX_BACKLOG:
            return
        kept: list[_Event] = []
        has_given_way = False
        for event, after in zip(self._backlog, [*self._backlog[1:], None], strict=True):
            may_give_way = event.is_update and after is not None and after.type == event.type
            has_given_way = may_give_way and not has_given_way
            if not has_given_way:
                kept.append(event)
        if self.is_refused and len(kept) >= _MAX_BACKLOG:
            _log.error("%d events were lost", len(kept) - _MAX_BACKLOG // 2)
            kept = kept[-_MAX_BACKLOG // 2 :]
        self._backlog = kept
        if len(kept) >= _MAX_BACKLOG and not self.is_refused:
            self._has_space.clear()
        else:
            self._has_space.set()


def _end(flushes: Sequence[asyncio.Future[None]]) -> None:
    for flushed in flushes:
        if not flushed.done():
            flushed.set_result(None)


class NullSink:
    """Drops events."""

    def put(self, event_type: str, data: Encoded, *, is_update: bool = False) -> None:
        """Drop an event."""

    async def wait_for_space(self) -> None:
        """Return at once."""
