"""Databases under test: how each is locked, filled and read behind the server's back."""

import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

from sqlalchemy import Engine, create_engine, text
from sqlalchemy.exc import DBAPIError

from benchmarks.chaos_rounds.disk import SmallDisk
from benchmarks.serving.server import pause
from tests.service.jobs.postgres import Cluster

# Longer than any disk is full [s].
_STARTS_WITHIN, _AGAIN = 60.0, 0.5


class Database(Protocol):
    """What a server keeps its records in.

    Attributes:
        name: Of its kind.
        disk: Whose fullness it feels.
    """

    name: str
    disk: SmallDisk

    @property
    def environment(self) -> Mapping[str, str]:
        """What tells a server to use it."""
        ...

    def locked(self) -> Any:
        """Return a context in which another connection has locked it."""
        ...

    def read_only(self) -> Any:
        """Return a context in which it can be read alone."""
        ...

    def away(self) -> Any:
        """Return a context in which it does not run; it always does if it is a file."""
        ...

    def rows(self, query: str) -> list[tuple[Any, ...]]:
        """Return what a query gives."""
        ...

    def close(self) -> None:
        """End it."""
        ...


class Sqlite:
    """SQLite in the data folder."""

    name = "sqlite"

    def __init__(self, data: Path, disk: SmallDisk) -> None:
        """Expect it where a server makes it."""
        self.disk = disk
        self._file = data / "wayproof.sqlite"
        self._engine = create_engine(f"sqlite:///{self._file}")

    @property
    def environment(self) -> Mapping[str, str]:
        """Nothing: it is what a server uses."""
        return {}

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the lock of who writes."""
        with self._engine.connect() as connection:
            connection.exec_driver_sql("PRAGMA busy_timeout=10000")
            connection.exec_driver_sql("BEGIN IMMEDIATE")
            yield
            connection.exec_driver_sql("ROLLBACK")

    @contextmanager
    def read_only(self) -> Iterator[None]:
        """Have its file and its log immutable.

        Not its index, which is mapped into memory: to write there would be a SIGBUS.
        """
        with self.disk.read_only([self._file, self._file.with_name(f"{self._file.name}-wal")]):
            yield

    @contextmanager
    def away(self) -> Iterator[None]:
        """Do nothing."""
        yield

    def rows(self, query: str) -> list[tuple[Any, ...]]:
        """Return what a query gives."""
        return _rows(self._engine, query)

    def close(self) -> None:
        """Close all connections."""
        self._engine.dispose()


class Postgresql:
    """A PostgreSQL server from a wheel, whose tables are on the small disk."""

    name = "postgresql"

    def __init__(self, folder: Path, disk: SmallDisk) -> None:
        """Make a new one in `folder`."""
        self.disk = disk
        folder.mkdir()
        self._cluster = Cluster(folder)
        self._cluster.start()
        self._engine = create_engine(self._cluster.url, pool_pre_ping=True)
        if disk.is_real:
            self._keep_tables(folder, disk.folder / "tables")

    @property
    def environment(self) -> Mapping[str, str]:
        """Its address."""
        return {"WAYPROOF_DATABASE_URL": self._cluster.url}

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold a lock that keeps all others from the jobs, readers too."""
        with self._engine.begin() as connection:
            connection.execute(text("LOCK TABLE jobs IN ACCESS EXCLUSIVE MODE"))
            yield

    @contextmanager
    def read_only(self) -> Iterator[None]:
        """Have it refuse to write, as a standby does."""
        self._refuse_writes(is_so=True)
        try:
            yield
        finally:
            _until_it_works(lambda: self._refuse_writes(is_so=False), DBAPIError)

    @contextmanager
    def away(self) -> Iterator[None]:
        """End it and all its connections, and start it again."""
        self._cluster.stop()
        try:
            yield
        finally:
            self._start_again()

    def rows(self, query: str) -> list[tuple[Any, ...]]:
        """Return what a query gives."""
        return _rows(self._engine, query)

    def close(self) -> None:
        """End it."""
        self._engine.dispose()
        self._cluster.stop()

    def _start_again(self) -> None:
        """Start it as soon as it can write what it has to: while the disk is full it cannot."""
        _until_it_works(self._cluster.start, subprocess.CalledProcessError)

    def _refuse_writes(self, *, is_so: bool) -> None:
        with self._engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            setting = "default_transaction_read_only"
            connection.execute(text(f"ALTER SYSTEM SET {setting} = {'on' if is_so else 'off'}"))
            connection.execute(text("SELECT pg_reload_conf()"))

    def _keep_tables(self, cluster: Path, folder: Path) -> None:
        """Have new tables on the small disk; what a transaction writes ahead is not on it."""
        folder.mkdir()
        owner = (cluster / "data").stat()
        shutil.chown(folder, owner.st_uid, owner.st_gid)
        with self._engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            connection.execute(text(f"CREATE TABLESPACE small LOCATION '{folder}'"))
            connection.execute(text("ALTER ROLE wp SET default_tablespace = 'small'"))


def _rows(engine: Engine, query: str) -> list[tuple[Any, ...]]:
    with engine.connect() as connection:
        return [tuple(row) for row in connection.execute(text(query))]


def _until_it_works(work: Callable[[], None], fault: type[Exception]) -> None:
    until = time.monotonic() + _STARTS_WITHIN
    while True:
        try:
            work()
        except fault:
            if time.monotonic() > until:
                raise
            pause(_AGAIN)
        else:
            return
