"""WaitingEntries: what waits in a queue, and which of it goes first.

1. What is of a higher level. A level is the priority, and one more for each `AGEING` seconds, up to
   the highest priority. Entries of one client and one priority are a line; the age of a line is how
   long its first entry has waited, or how long ago the line last had a worker if that is less. So
   a long line of low priority does not become urgent as a whole, and none is left behind.
2. Of one level, what is of the client that had no worker for longest: clients take turns.
3. Of one client, what came first.

Bound: a line whose age is `RANGE * AGEING` is of the highest level. From then on its first entry
waits for at most (n + 1) * m entries, if its client has n that came before it in other lines and m
clients have something that waits: between two turns of its client every other one has one turn at
most, and a client that comes later is behind. An entry with k before it in its line is first in it
after k such waits.
"""

import bisect
import heapq
import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from service.jobs.dispatch.scheduling.durations import CallKind
from service.jobs.job import Priority
from service.jobs.worker.assignment import Worker

# How long a line waits until it is of the next level [s].
AGEING = 30.0
_HIGHEST = Priority.HIGH.level
# From the lowest level to the highest.
RANGE = _HIGHEST - Priority.LOW.level


@dataclass(frozen=True)
class Place:
    """The place of an entry in its queue, which it keeps when it comes again.

    Attributes:
        since: When it came [s].
        order: How many came before.
    """

    since: float
    order: int


@dataclass(frozen=True)
class QueueEntry:
    """Something that waits for a worker.

    Attributes:
        name: Of the job, for taking it back.
        place: Its place in the queue.
        use: Called with its worker when it has one.
        world_digest: What it is warm with, or None.
        priority: Larger comes first.
        client: Whom it is for: clients take turns.
        kind: Of a call; None for a job.
    """

    name: str
    place: Place
    use: Callable[[Worker], None]
    world_digest: str | None = None
    priority: int = 0
    client: str = ""
    kind: CallKind | None = None


@dataclass
class _Line:
    """Entries of one client and priority, by their order, and when the last one had a worker."""

    priority: int
    entries: list[QueueEntry] = field(default_factory=list[QueueEntry])
    served_at: float = -math.inf


class WaitingEntries:
    """Entries that wait; has no clock."""

    def __init__(self) -> None:
        """Begin with none."""
        self._by_name: dict[str, QueueEntry] = {}
        self._lines: dict[tuple[str, int], _Line] = {}
        self._num_of: Counter[str] = Counter()
        # Of clients that have something that waits; the smallest is next.
        self._turns: dict[str, int] = {}
        self._next_turn = itertools.count()

    def __len__(self) -> int:
        """Return how many wait."""
        return len(self._by_name)

    def num_of(self, client: str) -> int:
        """Return how many of a client wait."""
        return self._num_of[client]

    def add(self, entry: QueueEntry) -> None:
        """Let an entry wait; one with an earlier place goes before."""
        self._by_name[entry.name] = entry
        line = self._lines.setdefault(_line_of(entry), _Line(entry.priority))
        bisect.insort(line.entries, entry, key=_order)
        self._num_of[entry.client] += 1
        if entry.client not in self._turns:
            self._turns[entry.client] = next(self._next_turn)

    def remove(self, name: str) -> None:
        """Let an entry wait no longer, if it did."""
        entry = self._by_name.pop(name, None)
        if entry is None:
            return
        line = self._lines[_line_of(entry)]
        del line.entries[bisect.bisect_left(line.entries, entry.place.order, key=_order)]
        if not line.entries:
            del self._lines[_line_of(entry)]
        self._num_of[entry.client] -= 1
        if not self._num_of[entry.client]:
            del self._num_of[entry.client], self._turns[entry.client]

    def names_of_jobs(self) -> list[str]:
        """Return the names of what waits and is no call."""
        return [name for name, entry in self._by_name.items() if entry.kind is None]

    def take(self, entry: QueueEntry, now: float) -> None:
        """Remove an entry that gets a worker: it was the turn of its client, and of its line."""
        self._lines[_line_of(entry)].served_at = now
        self.remove(entry.name)
        if entry.client in self._turns:
            self._turns[entry.client] = next(self._next_turn)

    def in_order(self, now: float) -> Iterator[QueueEntry]:
        """Yield what waits, in the order in which it gets workers; what is yielded may be taken."""
        heads = [(self._rank(line.entries[0], line, now), 0, line) for line in self._lines.values()]
        heapq.heapify(heads)
        while heads:
            rank, i, line = heads[0]
            entry = line.entries[i]
            current = self._rank(entry, line, now)
            if current != rank:  # another entry of its client was taken
                heapq.heapreplace(heads, (current, i, line))
                continue
            yield entry
            behind = i + (entry.name in self._by_name)
            if behind < len(line.entries):
                following = self._rank(line.entries[behind], line, now)
                heapq.heapreplace(heads, (following, behind, line))
            else:
                heapq.heappop(heads)

    def _rank(self, entry: QueueEntry, line: _Line, now: float) -> tuple[int, int, int]:
        """Return the smaller the sooner an entry goes; no two entries have the same."""
        age = max(0.0, now - max(entry.place.since, line.served_at))
        level = min(_HIGHEST, line.priority + int(age // AGEING))
        return (-level, self._turns[entry.client], entry.place.order)


def _line_of(entry: QueueEntry) -> tuple[str, int]:
    return (entry.client, entry.priority)


def _order(entry: QueueEntry) -> int:
    return entry.place.order
