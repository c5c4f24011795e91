"""Shutdown: what runs may end by itself for a while, and is then brought to its end.

Robots never wait for a plan: what moves one comes to rest at once, either way.
"""

import asyncio
from collections.abc import Mapping

from service.jobs.dispatch.attempt import Attempt
from service.jobs.dispatch.scheduling.scheduler import Scheduler

STOPPED = "the server stopped"
# To record the ends of what ran when the server stops [s].
_WRITING = 5.0


class Shutdown:
    """Ends the attempts of a dispatcher.

    Attributes:
        is_draining: Whether no job may begin any more.
    """

    def __init__(self, attempts: Mapping[str, Attempt], scheduler: Scheduler) -> None:
        """Be ready to end the attempts that there are, by the ids of their jobs."""
        self.is_draining = False
        self._attempts = attempts
        self._scheduler = scheduler

    def begin_to_drain(self) -> None:
        """Begin no job, and interrupt those that no other server can run again; questions go on."""
        self.is_draining = True
        self._scheduler.begin_to_drain()
        for attempt in self._running():
            if attempt.job.max_attempts == 1:  # it moves a robot
                attempt.interrupt(STOPPED)

    async def drained(self) -> None:
        """Wait until nothing runs."""
        while running := self._running():
            await asyncio.gather(*(attempt.concluded.wait() for attempt in running))

    def interrupt_all(self, reason: str) -> None:
        """Begin nothing, and interrupt what runs."""
        self._scheduler.pause()
        for attempt in self._running():
            attempt.interrupt(reason)

    async def concluded(self) -> int:
        """Wait for the ends of what was interrupted; return how many could not be recorded."""
        running = self._running()
        longest = max((attempt.grace for attempt in running), default=0.0) + _WRITING
        waits = [asyncio.ensure_future(attempt.concluded.wait()) for attempt in running]
        if not waits:
            return 0
        _, late = await asyncio.wait(waits, timeout=longest)
        for wait in late:
            wait.cancel()
        return len(late)

    def _running(self) -> list[Attempt]:
        return [attempt for attempt in self._attempts.values() if attempt.has_begun]
