"""Lane: what waits, and for how many slots of a pool it may run at once.

First come, first served within a priority. A ticket prefers an idle slot that is warm for its key.
If the slots that are warm for it are busy, it lets others go first, but only for a while: a load is
worth a short wait, never a long one.

Lanes that share a pool each have a number of slots that they may use at once, and the pool has as
many as all of them together: none waits for another one, and what one has loaded is warm for all.
A lane of questions keeps some of its own for those that are short.
"""

import bisect
import itertools
import math
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from service.jobs.worker.assignment import Worker
from service.jobs.worker_pool import WorkerPool

# What takes no longer may have the worker that is kept for what is short [s].
SHORT = 0.5
# So many scenes and kinds of questions to them are remembered.
_MOST = 4096


@dataclass(frozen=True)
class CallKind:
    """What questions that take about as long have in common.

    Attributes:
        task: Their task.
        size: How much is asked, in powers of two.
        is_load: Whether a scene is loaded anew, even where one is loaded already.
    """

    task: str
    size: int = 0
    is_load: bool = False


class DurationHistory:
    """Remembers the last duration of questions by kind and scene, and of loading a scene."""

    def __init__(self) -> None:
        """Remember nothing yet."""
        self._runs: OrderedDict[tuple[CallKind, str | None], float] = OrderedDict()
        self._loads: OrderedDict[str | None, float] = OrderedDict()

    def is_short(self, kind: CallKind, key: str | None, *, is_warm: bool) -> bool:
        """Return whether a question is likely to be short.

        A scene that was not loaded yet may take minutes; a question to a loaded one that was
        not asked yet is likely to be short.

        Args:
            kind: Of the question.
            key: Of its scene, or None.
            is_warm: Whether the scene is loaded where the question would be answered.
        """
        load = self._loads.get(key, math.inf)
        known = self._runs.get((kind, key))
        if kind.is_load:
            expected = load if known is None else known
        elif is_warm or key is None:
            expected = known or 0.0
        else:
            expected = load + (known or 0.0)
        return expected <= SHORT

    def record_run(
        self, kind: CallKind, key: str | None, seconds: float, *, was_warm: bool
    ) -> None:
        """Remember how long a question took, with the load of its scene if that was not warm."""
        if kind.is_load or was_warm or key is None:
            _put(self._runs, (kind, key), seconds)
        else:
            _put(self._loads, key, seconds)

    def record_load(self, key: str, seconds: float) -> None:
        """Remember how long a scene took to load."""
        _put(self._loads, key, seconds)


def _put[K](found: OrderedDict[K, float], key: K, seconds: float) -> None:
    found[key] = seconds
    found.move_to_end(key)
    if len(found) > _MOST:
        found.popitem(last=False)


_LONGEST_RETRY = 60


@dataclass(frozen=True)
class QueueEntry:
    """Something that waits for a slot.

    Attributes:
        name: Of the job, for taking it back.
        world_digest: What it is warm with, or None.
        priority: Larger comes first.
        since: When it began to wait [s].
        order: Its place among equals; assigned by the lane, and kept when it comes again.
        use: Called with its slot when it has one.
        kind: Of a question; None for a job.
    """

    name: str
    world_digest: str | None
    priority: int
    since: float
    use: Callable[[Worker], None]
    order: int = field(default=-1)
    kind: CallKind | None = None


@dataclass(frozen=True)
class Assignments:
    """What a lane decided.

    Attributes:
        pairs: Tickets and their slots.
        look_again: When to decide anew if nothing happens before [s], or None.
    """

    pairs: list[tuple[QueueEntry, Worker]]
    look_again: float | None


@dataclass(frozen=True)
class Share:
    """What a lane may use of its pool.

    Attributes:
        max_running: Workers at once; None for all.
        reserved: So many of them are for short questions only.
    """

    max_running: int | None = None
    reserved: int = 0


@dataclass(frozen=True)
class _Run:
    ticket: QueueEntry
    is_long: bool
    was_warm: bool


class JobQueue:
    """Decides who gets which slot; has no clock and starts nothing."""

    def __init__(
        self,
        name: str,
        workers: WorkerPool | Sequence[Worker],
        max_waiting: int,
        cancel_grace: float = 0.25,
        *,
        share: Share | None = None,
        warm_wait: float = 0.1,
    ) -> None:
        """Start with nothing that runs.

        Args:
            name: For messages.
            workers: Where its jobs run: of its own, or a pool that other lanes use as well.
            max_waiting: How many may wait.
            cancel_grace: How long a canceled job may take to end by itself [s].
            share: What it may use of the pool; None for all.
            warm_wait: How long a ticket waits for a warm slot while others are idle [s].
        """
        share = share or Share()
        self.name = name
        self.pool = workers if isinstance(workers, WorkerPool) else WorkerPool(workers)
        self.max_waiting = max_waiting
        self.cancel_grace = cancel_grace
        self.max_running = (
            len(self.pool.workers) if share.max_running is None else share.max_running
        )
        self.durations = DurationHistory()
        self._max_long = self.max_running - share.reserved
        self._warm_wait = warm_wait
        self._waiting: list[QueueEntry] = []
        self._running: dict[int, _Run] = {}
        self._orders = itertools.count()
        self._mean_run = 1.0

    @property
    def num_waiting(self) -> int:
        """How many tickets wait."""
        return len(self._waiting)

    @property
    def is_full(self) -> bool:
        """Whether no more may wait."""
        return len(self._waiting) >= self.max_waiting

    @property
    def retry_after(self) -> int:
        """When a place is likely to be free [s], by how long runs took lately."""
        rounds = (len(self._waiting) + 1) / max(1, self.max_running)
        return max(1, min(_LONGEST_RETRY, math.ceil(rounds * self._mean_run / 2)))

    def next_order(self) -> int:
        """Return the place of who comes now."""
        return next(self._orders)

    def add(self, ticket: QueueEntry) -> None:
        """Let a ticket wait; one with an earlier order goes before."""
        bisect.insort(self._waiting, ticket, key=lambda other: (-other.priority, other.order))

    def remove(self, name: str) -> None:
        """Let a ticket wait no longer, if it did."""
        self._waiting = [ticket for ticket in self._waiting if ticket.name != name]

    def end_run(self, slot: Worker, seconds: float | None = None) -> None:
        """Note that a run in a slot has ended, after so long; the pool may have the slot back."""
        run = self._running.pop(id(slot), None)
        if seconds is None or run is None:
            return
        self._mean_run += 0.2 * (seconds - self._mean_run)
        if run.ticket.kind is not None:
            asked = (run.ticket.kind, run.ticket.world_digest)
            self.durations.record_run(*asked, seconds, was_warm=run.was_warm)

    def assign(self, now: float) -> Assignments:
        """Take the tickets that get a slot now out of the queue, and their slots."""
        pairs: list[tuple[QueueEntry, Worker]] = []
        left: list[QueueEntry] = []
        look_again: float | None = None
        for i, ticket in enumerate(self._waiting):
            if not self.pool.has_idle or len(self._running) >= self.max_running:
                left += self._waiting[i:]
                break
            patience = ticket.since + self._warm_wait
            if now < patience and self.pool.is_warm_elsewhere(ticket.world_digest):
                left.append(ticket)
                look_again = patience if look_again is None else min(look_again, patience)
            elif (is_long := self._is_long(ticket)) and self._num_long >= self._max_long:
                left.append(ticket)
            else:
                pairs.append((ticket, self._take_worker(ticket, is_long=is_long)))
        self._waiting = left
        return Assignments(pairs, look_again)

    @property
    def _num_long(self) -> int:
        return sum(run.is_long for run in self._running.values())

    def _is_long(self, ticket: QueueEntry) -> bool:
        if ticket.kind is None:
            return True
        is_warm = self.pool.has_warm_idle(ticket.world_digest)
        return not self.durations.is_short(ticket.kind, ticket.world_digest, is_warm=is_warm)

    def _take_worker(self, ticket: QueueEntry, *, is_long: bool) -> Worker:
        was_warm = self.pool.has_warm_idle(ticket.world_digest)
        slot = self.pool.take(ticket.world_digest)
        self._running[id(slot)] = _Run(ticket, is_long, was_warm)
        return slot
