"""OwnershipWatch: notices that the lock on the database was lost, and takes it again if it may."""

import asyncio
import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Protocol

from service.jobs.errors import DatabaseTaken
from service.jobs.leader import DispatcherLock

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class DatabaseTimeouts:
    """How long a database is waited for; `takeover` bounds how long two servers move one robot.

    Attributes:
        period: Between two looks at the lock [s].
        answer: For the database to answer [s].
        regain: For the lock, before what runs is brought to its end [s].
        rest: For what runs to come to its end [s].
        record: For a new job to be written, before it is refused [s].
    """

    period: float = 1.0
    answer: float = 2.0
    regain: float = 5.0
    rest: float = 6.0
    record: float = 5.0

    @property
    def takeover(self) -> float:
        """How long after its loss of the lock an owner may still have something that runs [s]."""
        return self.period + 2 * self.answer + self.regain + self.rest


class LockListener(Protocol):
    """Who has to know; all are called in the event loop's thread."""

    def suspend(self) -> None:
        """Begin nothing, and end what runs: the database may be another's by now."""
        ...

    def resume(self) -> None:
        """Work again after `suspend`: the database had no other owner meanwhile."""
        ...

    def give_up(self) -> None:
        """End what runs, and do nothing more: another has the database."""
        ...


class LockWatch:
    """Watches one ownership from one event loop."""

    def __init__(
        self, lock: DispatcherLock, listener: LockListener, timeouts: DatabaseTimeouts
    ) -> None:
        """Tell `told` what becomes of `ownership`; `run` begins."""
        self._lock = lock
        self._listener = listener
        self._timeouts = timeouts
        self._threads = ThreadPoolExecutor(1, "ownership")

    async def run(self) -> None:
        """Watch until the database is another's, or this is canceled."""
        try:
            await self._watch()
        finally:
            # A question that is still asked could take the lock after it was released.
            await asyncio.to_thread(self._threads.shutdown)

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(self._timeouts.period)
            if await self._ask(self._lock.holds):
                continue
            _log.warning("the lock on the database was lost; taking it again")
            try:
                await self._regain()
            except DatabaseTaken:
                self._listener.give_up()
                return

    async def _regain(self) -> None:
        loop = asyncio.get_running_loop()
        until = loop.time() + self._timeouts.regain
        is_suspended = False
        while not await self._ask(self._lock.retake):
            if not is_suspended and loop.time() > until:
                is_suspended = True
                _log.error("the database is out of reach: what runs is brought to its end")
                self._listener.suspend()
            await asyncio.sleep(min(0.25, self._timeouts.period))
        _log.warning("the lock on the database is ours again")
        if is_suspended:
            self._listener.resume()

    async def _ask(self, question: Callable[[], bool]) -> bool:
        """Return the answer, False if there is none in time."""
        loop = asyncio.get_running_loop()
        try:
            async with asyncio.timeout(self._timeouts.answer):
                return await loop.run_in_executor(self._threads, question)
        except TimeoutError:
            # That thread waits for a connection that is dead; the next question must not.
            self._threads.shutdown(wait=False)
            self._threads = ThreadPoolExecutor(1, "ownership")
            return False
