"""Scheduler: brings together what waits in queues and the workers of their pools that get free."""

import asyncio
import logging
from collections.abc import Coroutine, Generator, Mapping
from contextlib import contextmanager
from contextvars import Context
from dataclasses import dataclass
from functools import partial
from typing import Any

from service.jobs.dispatch.observer import Observer
from service.jobs.dispatch.scheduling.queue import JobQueue
from service.jobs.dispatch.scheduling.waiting import Place, QueueEntry
from service.jobs.dispatch.scheduling.worker_pool import WorkerPool
from service.jobs.errors import QueueFull
from service.jobs.worker.assignment import Worker

# Until a worker is seen to that was given back while nothing waits [s].
_NO_HURRY = 0.002
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class QueueLoad:
    """How busy a queue is.

    Attributes:
        num_waiting: Jobs and questions that wait.
        num_running: Workers that they use.
        num_ready: Workers that may run them and are warm, busy or not.
    """

    num_waiting: int
    num_running: int
    num_ready: int


class Scheduler:
    """The queues of a dispatcher at work; belongs to one event loop.

    Attributes:
        observer: Hears of what happens, to count it.
    """

    def __init__(self, queues: Mapping[str, JobQueue], observer: Observer | None = None) -> None:
        """Start with no worker ready; `open` makes them so."""
        self.observer = observer or Observer()
        self._queues = queues
        self._pools = list({id(queue.pool): queue.pool for queue in queues.values()}.values())
        self._tasks: set[asyncio.Task[Any]] = set()
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self._returned: list[tuple[JobQueue, Worker]] = []
        self._taking_back: asyncio.TimerHandle | None = None
        self._is_closed = False
        self._is_paused = self._is_held = False

    def queue(self, name: str) -> JobQueue:
        """Return a queue."""
        return self._queues[name]

    def __contains__(self, name: str) -> bool:
        """Return whether there is such a queue."""
        return name in self._queues

    async def open(self, warm_up: str | None) -> None:
        """Begin to get all workers ready; each is used as soon as it is."""
        for pool in self._pools:
            for worker in pool.workers:
                await worker.open(warm_up)
                self.spawn(self._await_ready(pool, worker))

    def begin_to_drain(self) -> None:
        """Give workers to no more jobs; calls get them still."""
        for queue in self._queues.values():
            queue.begin_to_drain()

    def pause(self) -> None:
        """Give workers to nothing more until `resume`."""
        self._is_paused = True

    def resume(self) -> None:
        """Give workers to what waits again."""
        self._is_paused = False
        self._assign_all()

    @contextmanager
    def holding(self) -> Generator[None]:
        """Give workers to nothing meanwhile, so that what comes then is put into its order."""
        self._is_held = True
        try:
            yield
        finally:
            self._is_held = False
            self._assign_all()

    async def close(self) -> None:
        """End everything that runs, and all workers."""
        self._is_closed = True
        self._take_back()
        for timer in self._timers.values():
            timer.cancel()
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        workers = [worker for pool in self._pools for worker in pool.workers]
        await asyncio.gather(*(worker.close() for worker in workers))

    def faults(self) -> dict[str, str]:
        """Return why queues cannot begin a job well, by name; not those with one good worker.

        A worker that is being replaced just now is none.
        """
        found: dict[str, str] = {}
        for name, queue in self._queues.items():
            known = [worker.fault for worker in queue.pool.workers]
            if None not in known:
                found[name] = next(fault for fault in known if fault is not None)
        return found

    def loads(self) -> dict[str, QueueLoad]:
        """Return what waits and what works, by queue."""
        return {
            name: QueueLoad(
                queue.num_waiting,
                queue.num_running,
                sum(worker.fault is None for worker in queue.pool.workers),
            )
            for name, queue in self._queues.items()
        }

    def check_room(self, name: str, client: str, more: int = 1) -> None:
        """Go on only if a queue has room for `more` entries of a client.

        Raises:
            QueueFull: It may not.
        """
        queue = self._queues[name]
        if not queue.has_room(more, client):
            waiting, retry_after = queue.num_waiting, self.retry_after(name)
            raise QueueFull.of(name, waiting, queue.max_waiting, retry_after, more)

    def retry_after(self, name: str) -> int:
        """Return when a queue that is full is likely to have room [s]."""
        return self._queues[name].retry_after(_now())

    def next_place(self, name: str) -> Place:
        """Return the place in a queue of what comes now."""
        return self._queues[name].next_place(_now())

    def request(self, name: str, entry: QueueEntry) -> None:
        """Have an entry wait in a queue; what uses its worker must `release` it."""
        if self._returned:
            self._take_back()
        queue = self._queues[name]
        queue.add(entry)
        self._assign(queue)

    def release(self, name: str, worker: Worker, seconds: float) -> None:
        """Give a worker back after a run; it is used again once it is ready.

        If nothing waits, that is seen to a moment later, or when something comes: the client that
        waits for the end of the run is told before, and has the processor until then.
        """
        queue = self._queues[name]
        queue.end_run(worker, _now(), seconds)
        self._returned.append((queue, worker))
        if any(other.num_waiting for other in self._queues.values()):
            self._take_back()
        elif self._taking_back is None and not self._is_closed:
            loop = asyncio.get_running_loop()
            self._taking_back = loop.call_later(_NO_HURRY, self._take_back)

    def _take_back(self) -> None:
        """Have the workers used that were given back."""
        if self._taking_back is not None:
            self._taking_back.cancel()
            self._taking_back = None
        returned, self._returned = self._returned, []
        for queue, worker in returned:
            self.spawn(self._await_ready(queue.pool, worker))
            self._assign(queue)

    def return_worker(self, name: str, worker: Worker) -> None:
        """Take a worker back that was not used."""
        queue = self._queues[name]
        queue.take_back(worker)
        self.spawn(self._await_ready(queue.pool, worker))

    def spawn(self, work: Coroutine[Any, Any, None]) -> None:
        """Carry out work in the background; it is canceled when the scheduler closes."""
        if self._is_closed:
            work.close()
            return
        # What happens to begin it (a request, the end of another job) is no part of it.
        self.keep(asyncio.get_running_loop().create_task(work, context=Context()))

    def begin(self, work: Coroutine[Any, Any, None]) -> None:
        """Carry out work as `spawn` does, and its first step at once, not in the loop's next round.

        What it does until it first waits happens before this returns.
        """
        if self._is_closed:
            work.close()
            return
        loop = asyncio.get_running_loop()
        self.keep(asyncio.Task(work, loop=loop, context=Context(), eager_start=True))

    def keep(self, task: asyncio.Task[Any]) -> None:
        """Hold a task that works in the background; it is canceled when the scheduler closes."""
        self._tasks.add(task)
        task.add_done_callback(self._on_done)

    async def _await_ready(self, pool: WorkerPool, worker: Worker) -> None:
        await worker.ready()
        pool.give_back(worker)
        for queue in self._queues.values():
            if queue.pool is pool:
                self._assign(queue)

    def _assign_all(self) -> None:
        for queue in self._queues.values():
            self._assign(queue)

    def _assign(self, queue: JobQueue) -> None:
        if self._is_paused or self._is_held:
            return
        loop = asyncio.get_running_loop()
        for worker in queue.pool.take_lost():
            self.spawn(self._await_ready(queue.pool, worker))
        decided = queue.assign(_now())
        timer = self._timers.pop(queue.name, None)
        if timer is not None:
            timer.cancel()
        if decided.decide_again is not None:
            self._timers[queue.name] = loop.call_at(decided.decide_again, self._assign, queue)
        for entry, worker in decided.pairs:
            waited, was_warm = loop.time() - entry.place.since, queue.was_warm(worker)
            entry.use(worker)
            # The worker is told first.
            note = partial(self.observer.note_assignment, was_warm=was_warm)
            loop.call_soon(note, queue.name, waited)

    def _on_done(self, task: asyncio.Task[Any]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and (fault := task.exception()) is not None:
            _log.error("work in the background failed", exc_info=fault)


def _now() -> float:
    return asyncio.get_running_loop().time()
