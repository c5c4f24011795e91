"""One leader per database: a lock keeps others out, and an epoch fences off a former leader.

A lock that a database holds for us is lost with its connection, and nothing tells us. So every
owner counts the epoch up, and every write of a job asks in its own transaction whether the epoch is
still the writer's: a server that has lost the database cannot write, whether or not it knows.
"""

from collections.abc import Generator
from contextlib import contextmanager, suppress
from enum import Enum, auto
from typing import Any

from filelock import FileLock, Timeout
from sqlalchemy import Engine, insert, select, text, update
from sqlalchemy.exc import DBAPIError

from service.jobs.errors import DatabaseInUse, DatabaseTaken
from service.jobs.store.sql.tables import owner

# Any number will do, as long as every dispatcher uses the same.
_ADVISORY_KEY = 0x57_61_79_70
_LOCK = text("SELECT pg_try_advisory_lock(:key)")
_UNLOCK = text("SELECT pg_advisory_unlock(:key)")
_HOLDERS = text(
    "SELECT count(*) FROM pg_locks WHERE locktype = 'advisory' AND granted AND classid = 0"
    " AND objid = :key AND objsubid = 1"
    " AND database = (SELECT oid FROM pg_database WHERE datname = current_database())"
)
# A leader whose machine is gone keeps the lock until its connection is known to be dead [s].
_NOTICE_DEATH = (
    "SET tcp_keepalives_idle = 5; SET tcp_keepalives_interval = 2; SET tcp_keepalives_count = 3"
)


class Vacancy(Enum):
    """Whether a database has a leader.

    A lock that is free may be one whose holder was cut off, and is about to take it again.
    """

    HELD = auto()
    LOST = auto()
    GIVEN_BACK = auto()


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
        if self.epoch == 0:
            return
        given_back = update(owner).where(owner.c.epoch == self.epoch).values(is_released=True)
        try:
            with self._engine.begin() as connection:
                connection.execute(given_back)
        except DBAPIError:
            pass
        else:
            if self.may_be_lost and self._lock is not None:
                with suppress(DBAPIError):
                    self._lock.execute(_UNLOCK, {"key": _ADVISORY_KEY})
        finally:
            self._unlock()

    def vacancy(self) -> Vacancy:
        """Return whether another server leads; of a database in a server's hands.

        Raises:
            DBAPIError: The database does not answer.
        """
        with self._engine.connect() as connection:
            if connection.execute(_HOLDERS, {"key": _ADVISORY_KEY}).scalar_one():
                return Vacancy.HELD
            is_released = connection.execute(select(owner.c.is_released)).scalar_one_or_none()
        return Vacancy.LOST if is_released is False else Vacancy.GIVEN_BACK

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
            self._lock = self._lock_advisory()
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
            self._lock = self._lock_advisory()

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
            raise self._in_use("stop it, or choose another data folder") from fault
        return lock

    def _lock_advisory(self) -> Any:
        # Outside of a transaction, which would otherwise be open as long as the server runs.
        connection = self._engine.connect().execution_options(isolation_level="AUTOCOMMIT")
        try:
            if connection.execute(_LOCK, {"key": _ADVISORY_KEY}).scalar_one():
                connection.exec_driver_sql(_NOTICE_DEATH)
                return connection
        except BaseException:
            connection.invalidate()
            connection.close()
            raise
        connection.close()
        raise self._in_use("stop it, or choose another data folder")

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

    def of_other_version(self) -> DatabaseInUse:
        """Return the error for a server of another version that works on the database."""
        return self._in_use("it is of another version, and has to be stopped first")

    def _in_use(self, advice: str) -> DatabaseInUse:
        database = self._engine.url.render_as_string(hide_password=True)
        message = f"another server works on {database}; {advice}"
        return DatabaseInUse(message, {"database": database})
