"""The lock on a database is watched: by the leader, which may lose it, and by who follows."""

import asyncio
import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol

from sqlalchemy.exc import DBAPIError

from service.jobs.dispatch.leadership.leader import DispatcherLock, Vacancy
from service.jobs.dispatch.leadership.timeouts import DatabaseTimeouts
from service.jobs.errors import DatabaseInUse, DatabaseTaken
from service.jobs.store.sql.database import ask

_log = logging.getLogger(__name__)


class LockListener(Protocol):
    """What has to know; all methods are called in the event loop's thread."""

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
    """Notices that the lock on the database was lost, and takes it again if it may."""

    def __init__(
        self, lock: DispatcherLock, listener: LockListener, timeouts: DatabaseTimeouts
    ) -> None:
        """Tell `listener` what becomes of `lock`; `run` begins."""
        self._lock = lock
        self._listener = listener
        self._timeouts = timeouts
        self._threads = ThreadPoolExecutor(1, "dispatcher-lock")

    async def run(self) -> None:
        """Watch until the database is another's, or this is canceled."""
        try:
            await self._watch()
        finally:
            # A query that still runs could take the lock after it was released.
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
            self._threads = ThreadPoolExecutor(1, "dispatcher-lock")
            return False


class Standby:
    """Waits, beside a server that leads, until this one does."""

    def __init__(self, lock: DispatcherLock, timeouts: DatabaseTimeouts) -> None:
        """Wait for `lock`."""
        self._lock = lock
        self._timeouts = timeouts

    async def take(self) -> None:
        """Take the lock once it was given back, or has been free for long enough."""
        loop = asyncio.get_running_loop()
        lost_at: float | None = None
        while True:
            await asyncio.sleep(self._timeouts.period)
            vacancy = await self._vacancy()
            if vacancy is not Vacancy.LOST:
                lost_at = None
            elif lost_at is None:
                lost_at = loop.time()
            is_late = lost_at is not None and loop.time() >= lost_at + self._timeouts.patience
            if (is_late or vacancy is Vacancy.GIVEN_BACK) and await self._has_taken():
                return

    async def _vacancy(self) -> Vacancy:
        try:
            return await ask(self._lock.vacancy)
        except DBAPIError:  # it is away from the leader as well
            return Vacancy.HELD

    async def _has_taken(self) -> bool:
        try:
            await ask(self._lock.take)  # canceled, what is taken all the same is given back
        except (DatabaseInUse, DBAPIError):
            return False
        return True
