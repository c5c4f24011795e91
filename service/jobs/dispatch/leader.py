"""One dispatcher per database: a lock keeps others out, and an epoch fences off a former owner.

A lock that a database holds for us is lost with its connection, and nothing tells us. So every
owner counts the epoch up, and every write of a job asks in its own transaction whether the epoch is
still the writer's: a server that has lost the database cannot write, whether or not it knows.
"""

import asyncio
import logging
import threading
from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, Protocol

from filelock import FileLock, Timeout
from sqlalchemy import Engine, insert, select, text, update
from sqlalchemy.exc import DBAPIError

from service.jobs.dispatch.timeouts import DatabaseTimeouts
from service.jobs.errors import DatabaseInUse, DatabaseTaken
from service.jobs.store.tables import owner

# Any number will do, as long as every dispatcher uses the same.
_ADVISORY_KEY = 0x57_61_79_70
_ADVISORY_TRIES, _ADVISORY_PAUSE = 20, 0.1
_log = logging.getLogger(__name__)


class DispatcherLock:
    """Holds a database for one dispatcher until released, or until its process ends.

    Attributes:
        epoch: How many owners there have been, with this one.
        was_left: Whether the owner before did not give the database back.
    """

    def __init__(self, engine: Engine) -> None:
        """Take nothing yet."""
        self.epoch = 0
        self.was_left = False
        self._engine = engine
        self._lock: Any = None

    @property
    def may_be_lost(self) -> bool:
        """Whether the lock is in the database's hands, and so may be lost while we live."""
        return self._engine.dialect.name == "postgresql"

    def take(self) -> None:
        """Take the database.

        Raises:
            DatabaseInUse: Another dispatcher has it.
        """
        self._shut_out()
        try:
            self._count_up()
        except BaseException:
            self._unlock()
            raise

    @contextmanager
    def kept(self) -> Generator[None]:
        """Keep dispatchers out for as long as this lasts; owners are not counted up.

        Raises:
            DatabaseInUse: A dispatcher has it.
        """
        self._shut_out()
        try:
            yield
        finally:
            self._unlock()

    def release(self) -> None:
        """Give it back; a database that is gone is not told."""
        given_back = update(owner).where(owner.c.epoch == self.epoch).values(is_released=True)
        try:
            with self._engine.begin() as connection:
                connection.execute(given_back)
        except DBAPIError:
            pass
        finally:
            self._unlock()

    def holds(self) -> bool:
        """Return whether the connection that holds the lock lives; the lock lives as long."""
        try:
            self._lock.execute(text("SELECT 1"))
        except DBAPIError:
            return False
        return True

    def retake(self) -> bool:
        """Return whether the lock is ours again; not if the database is gone, or another has it.

        Raises:
            DatabaseTaken: There was another owner meanwhile.
        """
        try:
            self._unlock()
            self._lock = self._lock_advisory(1)
        except (DBAPIError, DatabaseInUse):
            held = False
        else:
            held = True
        try:
            with self._engine.connect() as connection:
                latest = connection.execute(select(owner.c.epoch)).scalar_one()
        except DBAPIError:
            return False
        if latest != self.epoch:
            evidence = {"epoch": self.epoch, "latest": latest}
            message = "another server has taken the database over while it was out of reach"
            raise DatabaseTaken(message, evidence)
        return held

    def _count_up(self) -> None:
        owner.create(self._engine, checkfirst=True)
        with self._engine.connect() as connection:
            before = connection.execute(select(owner)).first()
        with self._engine.begin() as connection:
            if before is None:
                self.epoch = 1
                connection.execute(insert(owner).values(id=1, epoch=1, is_released=False))
            else:
                self.epoch, self.was_left = before.epoch + 1, not before.is_released
                connection.execute(update(owner).values(epoch=self.epoch, is_released=False))

    def _shut_out(self) -> None:
        if self._engine.dialect.name == "sqlite":
            self._lock = self._lock_file()
        elif self.may_be_lost:
            self._lock = self._lock_advisory(_ADVISORY_TRIES)

    def _lock_file(self) -> Any:
        database = self._engine.url.database
        if not database or database == ":memory:":
            return None
        # Whichever thread releases it. Never a file that stays there when its owner dies, as some
        # file systems would have it: the kernel's lock ends with the process.
        lock = FileLock(
            f"{database}.lock", blocking=False, thread_local=False, fallback_to_soft=False
        )
        try:
            lock.acquire()
        except Timeout as fault:
            raise self._in_use() from fault
        return lock

    def _lock_advisory(self, tries: int) -> Any:
        # Outside of a transaction, which would otherwise be open as long as the server runs.
        connection = self._engine.connect().execution_options(isolation_level="AUTOCOMMIT")
        lock = text("SELECT pg_try_advisory_lock(:key)")
        # The database may need a moment to notice that an earlier server has died.
        for i in range(tries):
            if i > 0:
                threading.Event().wait(_ADVISORY_PAUSE)
            if connection.execute(lock, {"key": _ADVISORY_KEY}).scalar_one():
                return connection
        connection.close()
        raise self._in_use()

    def _unlock(self) -> None:
        """Let go before the connection returns to the pool, which would keep the lock."""
        held, self._lock = self._lock, None
        if held is None:
            return
        if self.may_be_lost:
            # Its end is the end of the lock, and needs no answer.
            held.invalidate()
            held.close()
        else:
            held.release()

    def _in_use(self) -> DatabaseInUse:
        database = self._engine.url.render_as_string(hide_password=True)
        message = f"another server works on {database}; stop it, or choose another data folder"
        return DatabaseInUse(message, {"database": database})


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
