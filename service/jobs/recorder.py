"""EventRecorder: what a run says, recorded in order, then published."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Sequence

from service.jobs.json_text import Encoded

_MAX_BACKLOG = 256
_log = logging.getLogger(__name__)

type Told = tuple[str, Encoded]


class EventRecorder:
    """Takes events at any pace and records what has gathered while the database was busy."""

    def __init__(self, record: Callable[[Sequence[Told]], Awaitable[None]]) -> None:
        """Record, and publish, by awaiting `record`."""
        self._record = record
        self._backlog: list[Told] = []
        self._pump: asyncio.Task[None] | None = None
        self._is_closed = False
        self._has_room = asyncio.Event()
        self._has_room.set()

    def put(self, event_type: str, data: Encoded) -> None:
        """Take an event; after `close` it is dropped."""
        if self._is_closed:
            return
        self._backlog.append((event_type[:64], data))
        if len(self._backlog) >= _MAX_BACKLOG:
            self._has_room.clear()
        if self._pump is None:
            self._pump = asyncio.get_running_loop().create_task(self._write())

    async def room(self) -> None:
        """Wait while there is much to record."""
        await self._has_room.wait()

    async def close(self) -> None:
        """Take no more, and wait until everything is recorded."""
        self._is_closed = True
        if self._pump is not None:
            await self._pump

    async def _write(self) -> None:
        while self._backlog:
            told, self._backlog = self._backlog, []
            self._has_room.set()
            try:
                await self._record(told)
            except Exception:  # noqa: BLE001  (the job itself goes on)
                _log.exception("%d events were lost", len(told))
        self._pump = None


class NoSink:
    """Drops events."""

    def put(self, event_type: str, data: Encoded) -> None:
        """Drop an event."""

    async def room(self) -> None:
        """Return at once."""
