"""JobQueue: which entry gets which worker of a pool next; has no clock and starts nothing.

Who goes first is said in `waiting`: priorities that age, and clients that take turns. An entry
prefers an idle worker that is warm for its world. If the workers that are warm for it are busy, it
lets others go first, but only for a while: a load is worth a short wait, never a long one.

Queues that share a pool each have a number of workers that they may use at once, and the pool has
as many as all of them together: none waits for another one, and what one has loaded is warm for
all. A queue of calls reserves some of its own for those that are short.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from service.jobs.dispatch.scheduling.durations import DurationHistory, Throughput
from service.jobs.dispatch.scheduling.waiting import Place, QueueEntry, WaitingEntries
from service.jobs.dispatch.scheduling.worker_pool import WorkerPool
from service.jobs.worker.assignment import Worker

_LONGEST_RETRY = 60
# One place of so many is for clients of which nothing waits.
_SHARE_KEPT = 10


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
        self._waiting = WaitingEntries()
        self._takes_jobs = True
        self._running: dict[int, _Run] = {}
        self._orders = itertools.count()
        self._throughput = Throughput()

    @property
    def num_waiting(self) -> int:
        """How many entries wait."""
        return len(self._waiting)

    @property
    def num_running(self) -> int:
        """How many workers it uses."""
        return len(self._running)

    def has_room(self, more: int = 1, client: str | None = None) -> bool:
        """Return whether there is room for `more` entries of a client.

        The last tenth of all places is for clients of which nothing waits: no client fills a queue.
        """
        is_waiting = client is not None and self._waiting.num_of(client) > 0
        kept = self.max_waiting // _SHARE_KEPT if is_waiting else 0
        return len(self._waiting) + more <= self.max_waiting - kept

    def retry_after(self, now: float) -> int:
        """Return when half of what waits will have had its turn [s], by the throughput lately."""
        seconds = (len(self._waiting) + 1) / 2 / self._throughput.per_second(now)
        return max(1, min(_LONGEST_RETRY, math.ceil(seconds)))

    def next_place(self, now: float) -> Place:
        """Return the place of an entry that comes now."""
        return Place(now, next(self._orders))

    def add(self, entry: QueueEntry) -> None:
        """Let an entry wait; one that comes again has its former place.

        A job that comes after `begin_to_drain` is not taken: another server has it next.
        """
        if entry.kind is None and not self._takes_jobs:
            return
        if not self._waiting:
            self._throughput.restart(entry.place.since)
        self._waiting.add(entry)

    def begin_to_drain(self) -> None:
        """Let no job wait any more, only calls."""
        self._takes_jobs = False
        for name in self._waiting.names_of_jobs():
            self._waiting.remove(name)

    def remove(self, name: str) -> None:
        """Let an entry wait no longer, if it did."""
        self._waiting.remove(name)

    def was_warm(self, worker: Worker) -> bool | None:
        """Return whether a worker had the world of what runs in it; None if that needs none."""
        run = self._running[id(worker)]
        return None if run.entry.world_digest is None else run.was_warm

    def take_back(self, worker: Worker) -> None:
        """Note that a worker was not used; the pool may have it back."""
        self._running.pop(id(worker), None)

    def end_run(self, worker: Worker, now: float, seconds: float) -> None:
        """Note that a run in a worker ends after so long; the pool may have it back."""
        run = self._running.pop(id(worker), None)
        if run is None:
            return
        self._throughput.record_end(now)
        if run.entry.kind is not None:
            call = (run.entry.kind, run.entry.world_digest)
            self.durations.record_run(*call, seconds, was_warm=run.was_warm)

    def assign(self, now: float) -> Assignments:
        """Take the entries that get a worker now out of the queue, and their workers."""
        pairs: list[tuple[QueueEntry, Worker]] = []
        decide_again: float | None = None
        if not self._has_free:
            return Assignments(pairs, decide_again)
        for entry in self._waiting.in_order(now):
            until = entry.place.since + self._warm_wait
            if now < until and self.pool.is_warm_elsewhere(entry.world_digest):
                decide_again = until if decide_again is None else min(decide_again, until)
            elif not (is_long := self._is_long(entry)) or self._num_long < self._max_long:
                self._waiting.take(entry, now)
                pairs.append((entry, self._take_worker(entry, is_long=is_long)))
                if not self._has_free:
                    break
        return Assignments(pairs, decide_again)

    @property
    def _has_free(self) -> bool:
        """Whether a worker is idle that may be used."""
        return self.pool.has_idle and len(self._running) < self.max_running

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
