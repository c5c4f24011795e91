"""EventBus: follows streams of numbered events live, on top of the log that is their record.

Events are published once they are recorded. A follower owns no queue: it knows the number that it
saw last and asks for what comes after it, from the short tail that is kept in memory or, if it is
slower than that, from the log. So any number of followers cost one tail, none can be overrun,
and no number is lost or repeated.
"""

import asyncio
from collections import deque
from collections.abc import AsyncGenerator, Awaitable, Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol

TAIL_LENGTH = 256


class Numbered(Protocol):
    """An event of a stream; numbers count from 1 without gaps."""

    @property
    def number(self) -> int:
        """Its place in the stream."""
        ...

    @property
    def is_last(self) -> bool:
        """Whether the stream ends with it."""
        ...


@dataclass(frozen=True)
class EventBatch[E: Numbered]:
    """Some events of a stream.

    Attributes:
        events: In order, perhaps not all that there are.
        is_over: Whether the stream had ended before the events were read.
    """

    events: Sequence[E]
    is_over: bool


class _Tail[E: Numbered]:
    """The newest events of a stream, and a signal of the next."""

    def __init__(self) -> None:
        self.events: deque[E] = deque(maxlen=TAIL_LENGTH)
        self.changed = asyncio.Event()
        self.num_followers = 0

    @property
    def is_over(self) -> bool:
        return bool(self.events) and self.events[-1].is_last

    def add(self, events: Sequence[E]) -> None:
        if self.is_over:
            return
        if self.events and events[0].number != self.events[-1].number + 1:
            self.events.clear()  # another server has recorded those between
        self.events.extend(events)
        self.wake()

    def wake(self) -> None:
        self.changed.set()
        self.changed = asyncio.Event()

    def after(self, seen: int) -> EventBatch[E] | None:
        """Return what follows a number, None if memory does not reach back so far."""
        if not self.events or seen < self.events[0].number - 1:
            return None
        return EventBatch([event for event in self.events if event.number > seen], self.is_over)


class EventBus[E: Numbered]:
    """Live fan-out of streams; belongs to one event loop."""

    def __init__(self, read: Callable[[str, int], Awaitable[EventBatch[E]]]) -> None:
        """Replay through `read(stream, after)`."""
        self._read = read
        self._tails: dict[str, _Tail[E]] = {}
        self._is_closed = False

    @property
    def num_streams(self) -> int:
        """How many streams are held in memory: those that go on, and those that are followed."""
        return len(self._tails)

    def publish(self, stream: str, events: Sequence[E]) -> None:
        """Tell followers of events that have been recorded, in the order of their numbers."""
        if not events:
            return
        tail = self._tails.setdefault(stream, _Tail())
        tail.add(events)
        self._forget(stream, tail)

    def wake(self, stream: str) -> None:
        """Have followers of a stream look at the log: another server has recorded more."""
        tail = self._tails.get(stream)
        if tail is not None and not tail.is_over:
            tail.events.clear()
            tail.wake()
            self._forget(stream, tail)

    def wake_all(self) -> None:
        """Have all followers look at the log."""
        for stream in list(self._tails):
            self.wake(stream)

    async def follow(self, stream: str, after: int = 0) -> AsyncGenerator[E]:
        """Yield what follows a number, recorded or to come, until the stream or the bus ends."""
        tail = self._tails.setdefault(stream, _Tail())
        tail.num_followers += 1
        seen = after
        try:
            while not self._is_closed:
                # Taken before reading: what is published meanwhile wakes us at once.
                changed = tail.changed
                batch = tail.after(seen) or await self._read(stream, seen)
                for event in batch.events:
                    yield event
                    seen = event.number
                if batch.is_over and (not batch.events or batch.events[-1].is_last):
                    return
                if not batch.events:
                    await changed.wait()
        finally:
            tail.num_followers -= 1
            self._forget(stream, tail)

    @contextmanager
    def watch(self, stream: str) -> Generator[Callable[[], asyncio.Event]]:
        """Watch a stream, without reading it: what is lent returns the event of its next change.

        A name that no events are recorded under is a stream as well: `wake` changes it.
        """
        tail = self._tails.setdefault(stream, _Tail())
        tail.num_followers += 1
        try:
            yield lambda: tail.changed
        finally:
            tail.num_followers -= 1
            self._forget(stream, tail)

    async def until_over(self, stream: str) -> None:
        """Wait until a stream that goes on ends, or the bus does; the log is not read."""
        tail = self._tails.setdefault(stream, _Tail())
        tail.num_followers += 1
        try:
            while not (self._is_closed or tail.is_over):
                await tail.changed.wait()
        finally:
            tail.num_followers -= 1
            self._forget(stream, tail)

    def close(self) -> None:
        """End every follower where it stands."""
        self._is_closed = True
        for tail in self._tails.values():
            tail.wake()

    def _forget(self, stream: str, tail: _Tail[E]) -> None:
        is_needed = tail.num_followers > 0 or (bool(tail.events) and not tail.is_over)
        if not is_needed and self._tails.get(stream) is tail:
            del self._tails[stream]
