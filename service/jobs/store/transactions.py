"""Transactions: what the threads of a server write into a database that may have other owners."""

import secrets
import threading
from collections.abc import Callable, Collection, Generator
from contextlib import contextmanager

from sqlalchemy import Connection, Engine, select

from service.jobs.errors import DatabaseTaken
from service.jobs.store.queries import JobQueries
from service.jobs.store.sql.database import begin_notes, set_durability, sync_log
from service.jobs.store.sql.notifications import Listener, notify
from service.jobs.store.sql.prepared import Prepared
from service.jobs.store.sql.schema import bring_up_to_date, is_up_to_date, refuse_newer
from service.jobs.store.sql.tables import owner

_EPOCH = Prepared(select(owner.c.epoch).with_for_update(read=True))


class Transactions(JobQueries):
    """Writes of one server, from any thread; each says which jobs it changes.

    Attributes:
        sender: What the notifications of its changes begin with.
    """

    def __init__(self, engine: Engine) -> None:
        """Write to `engine`."""
        super().__init__(engine)
        self.sender = secrets.token_hex(4)
        self._epoch: int | None = None
        self._lock = threading.RLock()
        self._open_transaction: Connection | None = None
        self._keeps = False
        self._kept: Connection | None = None

    def open(self) -> None:
        """Bring the database to the newest revision.

        Raises:
            DatabaseTooNew: A newer version has changed it.
            DatabaseUnrecognized: Its tables are not this program's.
        """
        bring_up_to_date(self._engine)

    def refuse_newer(self) -> None:
        """Look at the database, and write nothing to it.

        Raises:
            DatabaseTooNew: A newer version has changed it.
        """
        refuse_newer(self._engine)

    def is_up_to_date(self) -> bool:
        """Return whether the database has this version's revision."""
        return is_up_to_date(self._engine)

    def listener(self, on_change: Callable[[Collection[str] | None], None]) -> Listener:
        """Return what hears of the changes of other servers; see `Listener`."""
        return Listener(self._engine, self.sender, on_change)

    @property
    def is_shared(self) -> bool:
        """Whether other servers may work on the database."""
        return self._engine.dialect.name == "postgresql"

    def set_epoch(self, epoch: int) -> None:
        """Write only as long as the owner of the database is the one of an epoch."""
        self._epoch = epoch

    @contextmanager
    def transaction(self, *, is_durable: bool) -> Generator[Connection]:
        """Make what this thread writes meanwhile one transaction.

        Args:
            is_durable: Whether it must survive a power cut. The death of the server, and of the
                database alone, it survives in any case.

        Raises:
            DatabaseTaken: The database has another owner; nothing was written.
        """
        with self._lock:
            if self._open_transaction is not None:
                yield self._open_transaction
                return
            with self._connected() as connection:
                set_durability(connection, is_durable=is_durable)
                self._open_transaction = connection
                begin_notes(connection)
                try:
                    yield connection
                    self._check_ownership(connection)
                    notify(connection, self.sender)
                    connection.commit()
                finally:
                    self._open_transaction = None

    @contextmanager
    def keeping_connection(self) -> Generator[None]:
        """Have transactions meanwhile use one connection, where that cannot break by itself.

        To take one from the pool and give it back takes as long as some of its statements.
        """
        with self._lock:
            self._keeps = not self.is_shared
        try:
            yield
        finally:
            with self._lock:
                self._keeps = False
                self._forget_connection()

    @contextmanager
    def _connected(self) -> Generator[Connection]:
        """Lend a connection; one that is kept is closed after a fault, which it may remember."""
        if not self._keeps:
            with self._engine.connect() as connection:
                yield connection
            return
        if self._kept is None:
            self._kept = self._engine.connect()
        try:
            yield self._kept
        except BaseException:
            self._forget_connection()
            raise

    def _forget_connection(self) -> None:
        kept, self._kept = self._kept, None
        if kept is not None:
            kept.close()

    def flush(self) -> None:
        """Make durable what was committed before this.

        Raises:
            OSError: The disk does not take it.
        """
        sync_log(self._engine)

    def _check_ownership(self, connection: Connection) -> None:
        """Go on to the commit only if no other server has taken the database; it cannot before it.

        Raises:
            DatabaseTaken: One has.
        """
        if self._epoch is None:
            return
        latest = _EPOCH(connection).scalar()
        if latest != self._epoch:
            message = "another server has taken the database over: nothing is written to it here"
            raise DatabaseTaken(message, {"epoch": self._epoch, "latest": latest})
