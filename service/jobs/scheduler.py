"""Floor: brings together what waits in lanes and the slots of their pools that get free."""

import asyncio
import logging
from collections.abc import Callable, Coroutine, Mapping
from dataclasses import dataclass
from typing import Any

from service.jobs.durations import CallKind
from service.jobs.errors import QueueFull
from service.jobs.queue import JobQueue, QueueEntry
from service.jobs.worker.process_worker import Worker
from service.jobs.worker_pool import WorkerPool

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class QueueLoad:
    """How busy a queue is.

    Attributes:
        num_waiting: Jobs and questions that wait.
        num_ready: Workers that may run them and are warm, busy or not.
    """

    num_waiting: int
    num_ready: int


class Scheduler:
    """The lanes of a dispatcher at work; belongs to one event loop."""

    def __init__(self, lanes: Mapping[str, JobQueue]) -> None:
        """Start with no slot ready; `open` makes them so."""
        self._queues = lanes
        self._pools = list({id(lane.pool): lane.pool for lane in lanes.values()}.values())
        self._tasks: set[asyncio.Task[Any]] = set()
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self._is_closed = False
        self._is_held = False

    def queue(self, name: str) -> JobQueue:
        """Return a lane."""
        return self._queues[name]

    def __contains__(self, name: str) -> bool:
        """Return whether there is such a lane."""
        return name in self._queues

    async def open(self, warm_up: str | None) -> None:
        """Begin to get all slots ready; each is used as soon as it is."""
        for pool in self._pools:
            for slot in pool.workers:
                await slot.open(warm_up)
                self.spawn(self._await_ready(pool, slot))

    @property
    def workers(self) -> list[Worker]:
        """All slots of all pools."""
        return [slot for pool in self._pools for slot in pool.workers]

    def pause(self) -> None:
        """Give slots to nothing more until `go_on`."""
        self._is_held = True

    def resume(self) -> None:
        """Give slots to what waits again."""
        self._is_held = False
        for lane in self._queues.values():
            self._assign(lane)

    async def close(self) -> None:
        """End everything that runs, and all slots."""
        self._is_closed = True
        for timer in self._timers.values():
            timer.cancel()
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await asyncio.gather(*(slot.close() for slot in self.workers))

    def faults(self) -> dict[str, str]:
        """Return why lanes cannot begin a job well, by name; those with one good slot are left out.

        A slot that is being replaced just now is none.
        """
        found: dict[str, str] = {}
        for name, lane in self._queues.items():
            known = [slot.fault for slot in lane.pool.workers]
            if None not in known:
                found[name] = next(fault for fault in known if fault is not None)
        return found

    def loads(self) -> dict[str, QueueLoad]:
        """Return what waits and what works, by queue."""
        return {
            name: QueueLoad(
                queue.num_waiting, sum(worker.fault is None for worker in queue.pool.workers)
            )
            for name, queue in self._queues.items()
        }

    def check_room(self, name: str) -> None:
        """Go on only if one more may wait in a lane.

        Raises:
            QueueFull: It may not.
        """
        lane = self._queues[name]
        if lane.is_full:
            message = f"{lane.num_waiting} jobs wait for {name} already; try again later"
            evidence = {
                "lane": name,
                "queued": lane.num_waiting,
                "bound": lane.max_waiting,
                "retry_after": lane.retry_after,
            }
            raise QueueFull(message, evidence)

    def request_worker(
        self,
        name: str,
        ticket: str,
        use: Callable[[Worker], None],
        *,
        world_digest: str | None = None,
        priority: int = 0,
        order: int | None = None,
    ) -> int:
        """Call `use` with a slot as soon as there is one; return the place in the queue.

        Args:
            name: Of the lane.
            ticket: Who waits.
            use: Gets the slot, and must `release` it.
            world_digest: What a slot may be warm with.
            priority: Larger comes first.
            order: The place of who waits again.
        """
        lane = self._queues[name]
        place = lane.next_order() if order is None else order
        self._wait(lane, QueueEntry(ticket, world_digest, priority, _now(), use, place))
        return place

    def request_for_call(
        self, name: str, ticket: str, use: Callable[[Worker], None], key: str | None, kind: CallKind
    ) -> None:
        """Call `use` with a slot for a question of a kind about a scene; else as `seat`."""
        lane = self._queues[name]
        self._wait(lane, QueueEntry(ticket, key, 0, _now(), use, lane.next_order(), kind))

    def release(self, name: str, slot: Worker, seconds: float) -> None:
        """Give a slot back after a run; it is used again once it is ready."""
        lane = self._queues[name]
        lane.end_run(slot, seconds)
        self.spawn(self._await_ready(lane.pool, slot))
        self._assign(lane)

    def return_worker(self, name: str, slot: Worker) -> None:
        """Take a slot back that was not used."""
        lane = self._queues[name]
        lane.end_run(slot)
        self.spawn(self._await_ready(lane.pool, slot))

    def spawn(self, work: Coroutine[Any, Any, None]) -> None:
        """Carry out work that nobody waits for; it is canceled when the floor closes."""
        if self._is_closed:
            work.close()
            return
        self.keep(asyncio.get_running_loop().create_task(work))

    def keep(self, task: asyncio.Task[Any]) -> None:
        """Hold a task that works in the background; it is canceled when the floor closes."""
        self._tasks.add(task)
        task.add_done_callback(self._on_done)

    def _wait(self, lane: JobQueue, ticket: QueueEntry) -> None:
        lane.add(ticket)
        self._assign(lane)

    async def _await_ready(self, pool: WorkerPool, slot: Worker) -> None:
        await slot.ready()
        pool.give_back(slot)
        for lane in self._queues.values():
            if lane.pool is pool:
                self._assign(lane)

    def _assign(self, lane: JobQueue) -> None:
        if self._is_held:
            return
        loop = asyncio.get_running_loop()
        decided = lane.assign(loop.time())
        timer = self._timers.pop(lane.name, None)
        if timer is not None:
            timer.cancel()
        if decided.look_again is not None:
            self._timers[lane.name] = loop.call_at(decided.look_again, self._assign, lane)
        for ticket, slot in decided.pairs:
            ticket.use(slot)

    def _on_done(self, task: asyncio.Task[Any]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and (fault := task.exception()) is not None:
            _log.error("work in the background failed", exc_info=fault)


def _now() -> float:
    return asyncio.get_running_loop().time()
