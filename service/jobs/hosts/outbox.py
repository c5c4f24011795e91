"""Outbox: what a host has to say, until the dispatcher collects it."""

import asyncio
from contextlib import suppress

from service.jobs.context import MADE
from service.jobs.hosts.messages import HostMessage, HostMessageKind, batch_of, pack
from service.jobs.json_text import Encoded

# Number of waiting messages beyond which updates are dropped: the next one has what they had.
_MAX_UPDATES = 4096
# Number of events of a run that may be on their way before its task waits.
WINDOW = 64


class Outbox:
    """Messages in their order; belongs to one event loop."""

    def __init__(self) -> None:
        """Begin with none."""
        self._waiting: list[HostMessage] = []
        self._has_some = asyncio.Event()

    def put(self, message: HostMessage) -> None:
        """Add a message; an update is dropped if there is much to say."""
        is_update = message.kind is HostMessageKind.UPDATE
        if is_update and len(self._waiting) >= _MAX_UPDATES:
            return
        self._waiting.append(message)
        self._has_some.set()

    async def collect(self, patience: float) -> bytes:
        """Return what there is to say, at most about a batch; wait for it at most so long [s]."""
        with suppress(TimeoutError):
            async with asyncio.timeout(patience):
                await self._has_some.wait()
        batch = batch_of(self._waiting)
        if not self._waiting:
            self._has_some.clear()
        return pack(batch)


class OutboxSink:
    """Takes the events of a run on a host; at most so many are on their way."""

    def __init__(self, outbox: Outbox, worker: int, run: int) -> None:
        """Send the events of a run of a worker."""
        self._outbox = outbox
        self._about = (worker, run)
        self._num_on_way = 0
        self._has_space = asyncio.Event()
        self._has_space.set()

    def put(self, event_type: str, data: Encoded, *, is_update: bool = False) -> None:
        """Take an event; what it says of artifacts is for the dispatcher alone."""
        if event_type == MADE:
            self._outbox.put(HostMessage(HostMessageKind.MADE, *self._about, data.text.encode()))
            return
        kind = HostMessageKind.UPDATE if is_update else HostMessageKind.EVENT
        name = event_type.replace("\n", " ")
        self._outbox.put(HostMessage(kind, *self._about, f"{name}\n{data.text}".encode()))
        if not is_update:
            self._num_on_way += 1
            if self._num_on_way >= WINDOW:
                self._has_space.clear()

    async def wait_for_space(self) -> None:
        """Wait while too many events are on their way."""
        await self._has_space.wait()

    def note_received(self, count: int) -> None:
        """Note how many events the dispatcher has dealt with."""
        self._num_on_way -= count
        if self._num_on_way < WINDOW:
            self._has_space.set()
