"""Floor: brings together what waits in lanes and the slots of their pools that get free."""

import asyncio
import logging
from collections.abc import Callable, Coroutine, Mapping
from typing import Any

from service.jobs.durations import Kind
from service.jobs.errors import QueueFull
from service.jobs.lane import Lane, Ticket
from service.jobs.pool import Pool
from service.jobs.slot import Slot

_log = logging.getLogger(__name__)


class Floor:
    """The lanes of a dispatcher at work; belongs to one event loop."""

    def __init__(self, lanes: Mapping[str, Lane]) -> None:
        """Start with no slot ready; `open` makes them so."""
        self._lanes = lanes
        self._pools = list({id(lane.pool): lane.pool for lane in lanes.values()}.values())
        self._tasks: set[asyncio.Task[Any]] = set()
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self._is_closed = False
        self._is_held = False

    def lane(self, name: str) -> Lane:
        """Return a lane."""
        return self._lanes[name]

    def __contains__(self, name: str) -> bool:
        """Return whether there is such a lane."""
        return name in self._lanes

    async def open(self, warm_up: str | None) -> None:
        """Begin to get all slots ready; each is used as soon as it is."""
        for pool in self._pools:
            for slot in pool.slots:
                await slot.open(warm_up)
                self.spawn(self._admit(pool, slot))

    @property
    def slots(self) -> list[Slot]:
        """All slots of all pools."""
        return [slot for pool in self._pools for slot in pool.slots]

    def hold(self) -> None:
        """Give slots to nothing more until `go_on`."""
        self._is_held = True

    def go_on(self) -> None:
        """Give slots to what waits again."""
        self._is_held = False
        for lane in self._lanes.values():
            self._assign(lane)

    async def close(self) -> None:
        """End everything that runs, and all slots."""
        self._is_closed = True
        for timer in self._timers.values():
            timer.cancel()
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await asyncio.gather(*(slot.close() for slot in self.slots))

    def faults(self) -> dict[str, str]:
        """Return why lanes cannot begin a job well, by name; those with one good slot are left out.

        A slot that is being replaced just now is none.
        """
        found: dict[str, str] = {}
        for name, lane in self._lanes.items():
            known = [slot.fault for slot in lane.pool.slots]
            if None not in known:
                found[name] = next(fault for fault in known if fault is not None)
        return found

    def require_room(self, name: str) -> None:
        """Go on only if one more may wait in a lane.

        Raises:
            QueueFull: It may not.
        """
        lane = self._lanes[name]
        if lane.is_full:
            message = f"{lane.num_waiting} jobs wait for {name} already; try again later"
            evidence = {
                "lane": name,
                "queued": lane.num_waiting,
                "bound": lane.max_waiting,
                "retry_after": lane.retry_after,
            }
            raise QueueFull(message, evidence)

    def seat(
        self,
        name: str,
        ticket: str,
        use: Callable[[Slot], None],
        *,
        warm_key: str | None = None,
        priority: int = 0,
        order: int | None = None,
    ) -> int:
        """Call `use` with a slot as soon as there is one; return the place in the queue.

        Args:
            name: Of the lane.
            ticket: Who waits.
            use: Gets the slot, and must `release` it.
            warm_key: What a slot may be warm with.
            priority: Larger comes first.
            order: The place of who waits again.
        """
        lane = self._lanes[name]
        place = lane.next_order() if order is None else order
        self._wait(lane, Ticket(ticket, warm_key, priority, _now(), use, place))
        return place

    def seat_question(
        self, name: str, ticket: str, use: Callable[[Slot], None], key: str | None, kind: Kind
    ) -> None:
        """Call `use` with a slot for a question of a kind about a scene; else as `seat`."""
        lane = self._lanes[name]
        self._wait(lane, Ticket(ticket, key, 0, _now(), use, lane.next_order(), kind))

    def release(self, name: str, slot: Slot, seconds: float) -> None:
        """Give a slot back after a run; it is used again once it is ready."""
        lane = self._lanes[name]
        lane.leave(slot, seconds)
        self.spawn(self._admit(lane.pool, slot))
        self._assign(lane)

    def readmit(self, name: str, slot: Slot) -> None:
        """Take a slot back that was not used."""
        lane = self._lanes[name]
        lane.leave(slot)
        self.spawn(self._admit(lane.pool, slot))

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

    def _wait(self, lane: Lane, ticket: Ticket) -> None:
        lane.add(ticket)
        self._assign(lane)

    async def _admit(self, pool: Pool, slot: Slot) -> None:
        await slot.ready()
        pool.give_back(slot)
        for lane in self._lanes.values():
            if lane.pool is pool:
                self._assign(lane)

    def _assign(self, lane: Lane) -> None:
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
