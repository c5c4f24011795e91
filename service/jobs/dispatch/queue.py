"""JobQueue: which entry gets which worker of a pool next; has no clock and starts nothing.

First come, first served within a priority. An entry prefers an idle worker that is warm for its
world. If the workers that are warm for it are busy, it lets others go first, but only for a while:
a load is worth a short wait, never a long one.

Queues that share a pool each have a number of workers that they may use at once, and the pool has
as many as all of them together: none waits for another one, and what one has loaded is warm for
all. A queue of calls reserves some of its own for those that are short.
"""

import bisect
import itertools
import math
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from service.jobs.dispatch.worker_pool import WorkerPool
from service.jobs.worker.assignment import Worker

# What takes no longer may have the worker that is reserved for what is short [s].
SHORT = 0.5
# Number of worlds, and of kinds of calls about them, that are remembered.
_MAX_REMEMBERED = 4096
_LONGEST_RETRY = 60


@dataclass(frozen=True)
class CallKind:
    """What calls that take about as long have in common.

    Attributes:
        task: Their task.
        size: How much is requested, in powers of two.
        is_load: Whether a scene is loaded anew, even where one is loaded already.
    """

    task: str
    size: int = 0
    is_load: bool = False


class DurationHistory:
    """Remembers the last duration of calls by kind and world, and of loading a world."""

    def __init__(self) -> None:
        """Remember nothing yet."""
        self._runs: OrderedDict[tuple[CallKind, str | None], float] = OrderedDict()
        self._loads: OrderedDict[str | None, float] = OrderedDict()

    def is_short(self, kind: CallKind, digest: str | None, *, is_warm: bool) -> bool:
        """Return whether a call is likely to be short.

        A world that was not loaded yet may take minutes; a call to a loaded one of a kind that it
        had not yet is likely to be short.

        Args:
            kind: Of the call.
            digest: Of its world, or None.
            is_warm: Whether the world is loaded where the call would run.
        """
        load = self._loads.get(digest, math.inf)
        known = self._runs.get((kind, digest))
        if kind.is_load:
            expected = load if known is None else known
        elif is_warm or digest is None:
            expected = known or 0.0
        else:
            expected = load + (known or 0.0)
        return expected <= SHORT

    def record_run(
        self, kind: CallKind, digest: str | None, seconds: float, *, was_warm: bool
    ) -> None:
        """Remember how long a call took, with the load of its world if that was not warm."""
        if kind.is_load or was_warm or digest is None:
            _put(self._runs, (kind, digest), seconds)
        else:
            _put(self._loads, digest, seconds)

    def record_load(self, digest: str, seconds: float) -> None:
        """Remember how long a world took to load."""
        _put(self._loads, digest, seconds)


def _put[K](durations: OrderedDict[K, float], key: K, seconds: float) -> None:
    durations[key] = seconds
    durations.move_to_end(key)
    if len(durations) > _MAX_REMEMBERED:
        durations.popitem(last=False)


@dataclass(frozen=True)
class QueueEntry:
    """Something that waits for a worker.

    Attributes:
        name: Of the job, for taking it back.
        world_digest: What it is warm with, or None.
        priority: Larger comes first.
        since: When it began to wait [s].
        use: Called with its worker when it has one.
        order: Its place among equals; assigned by the queue, and kept when it comes again.
        kind: Of a call; None for a job.
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
    """What a queue decided.

    Attributes:
        pairs: Entries and their workers.
        decide_again: When to decide anew if nothing happens before [s], or None.
    """

    pairs: list[tuple[QueueEntry, Worker]]
    decide_again: float | None


@dataclass(frozen=True)
class Share:
    """What a queue may use of its pool.

    Attributes:
        max_running: Workers at once; None for all.
        reserved: Number of them that is for short calls only.
    """

    max_running: int | None = None
    reserved: int = 0


@dataclass(frozen=True)
class _Run:
    entry: QueueEntry
    is_long: bool
    was_warm: bool


class JobQueue:
    """What waits, and for how many workers of a pool it may run at once."""

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
            workers: Where its jobs run: of its own, or a pool that other queues use as well.
            max_waiting: How many may wait.
            cancel_grace: How long a canceled job may take to end by itself [s].
            share: What it may use of the pool; None for all.
            warm_wait: How long an entry waits for a warm worker while others are idle [s].
        """
        share = share or Share()
        self.name = name
        self.pool = workers if isinstance(workers, WorkerPool) else WorkerPool(workers)
        self.max_waiting = max_waiting
        self.cancel_grace = cancel_grace
        most = share.max_running
        self.max_running = len(self.pool.workers) if most is None else most
        self.durations = DurationHistory()
        self._max_long = self.max_running - share.reserved
        self._warm_wait = warm_wait
        self._takes_jobs = True
        self._waiting: list[QueueEntry] = []
        self._running: dict[int, _Run] = {}
        self._orders = itertools.count()
        self._mean_run = 1.0

    @property
    def num_waiting(self) -> int:
        """How many entries wait."""
        return len(self._waiting)

    @property
    def num_running(self) -> int:
        """How many workers it uses."""
        return len(self._running)

    def has_room(self, more: int = 1) -> bool:
        """Return whether so many more may wait."""
        return len(self._waiting) + more <= self.max_waiting

    @property
    def retry_after(self) -> int:
        """When a place is likely to be free [s], by how long runs took lately."""
        rounds = (len(self._waiting) + 1) / max(1, self.max_running)
        return max(1, min(_LONGEST_RETRY, math.ceil(rounds * self._mean_run / 2)))

    def next_order(self) -> int:
        """Return the place of an entry that comes now."""
        return next(self._orders)

    def add(self, entry: QueueEntry) -> None:
        """Let an entry wait; one with an earlier order goes before.

        A job that comes after `begin_to_drain` is not taken: another server has it next.
        """
        if entry.kind is None and not self._takes_jobs:
            return
        bisect.insort(self._waiting, entry, key=lambda other: (-other.priority, other.order))

    def begin_to_drain(self) -> None:
        """Let no job wait any more, only calls."""
        self._takes_jobs = False
        self._waiting = [entry for entry in self._waiting if entry.kind is not None]

    def remove(self, name: str) -> None:
        """Let an entry wait no longer, if it did."""
        self._waiting = [entry for entry in self._waiting if entry.name != name]

    def was_warm(self, worker: Worker) -> bool | None:
        """Return whether a worker had the world of what runs in it; None if that needs none."""
        run = self._running[id(worker)]
        return None if run.entry.world_digest is None else run.was_warm

    def end_run(self, worker: Worker, seconds: float | None = None) -> None:
        """Note that a run in a worker has ended, after so long; the pool may have it back."""
        run = self._running.pop(id(worker), None)
        if seconds is None or run is None:
            return
        self._mean_run += 0.2 * (seconds - self._mean_run)
        if run.entry.kind is not None:
            call = (run.entry.kind, run.entry.world_digest)
            self.durations.record_run(*call, seconds, was_warm=run.was_warm)

    def assign(self, now: float) -> Assignments:
        """Take the entries that get a worker now out of the queue, and their workers."""
        pairs: list[tuple[QueueEntry, Worker]] = []
        left: list[QueueEntry] = []
        decide_again: float | None = None
        for i, entry in enumerate(self._waiting):
            if not self.pool.has_idle or len(self._running) >= self.max_running:
                left += self._waiting[i:]
                break
            until = entry.since + self._warm_wait
            if now < until and self.pool.is_warm_elsewhere(entry.world_digest):
                left.append(entry)
                decide_again = until if decide_again is None else min(decide_again, until)
            elif (is_long := self._is_long(entry)) and self._num_long >= self._max_long:
                left.append(entry)
            else:
                pairs.append((entry, self._take_worker(entry, is_long=is_long)))
        self._waiting = left
        return Assignments(pairs, decide_again)

    @property
    def _num_long(self) -> int:
        return sum(run.is_long for run in self._running.values())

    def _is_long(self, entry: QueueEntry) -> bool:
        if entry.kind is None:
            return True
        is_warm = self.pool.has_warm_idle(entry.world_digest)
        return not self.durations.is_short(entry.kind, entry.world_digest, is_warm=is_warm)

    def _take_worker(self, entry: QueueEntry, *, is_long: bool) -> Worker:
        was_warm = self.pool.has_warm_idle(entry.world_digest)
        worker = self.pool.take(entry.world_digest)
        self._running[id(worker)] = _Run(entry, is_long, was_warm)
        return worker
