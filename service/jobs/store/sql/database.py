"""Databases: how they are opened, and how durable a transaction is."""

import asyncio
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from sqlalchemy import (
    Connection,
    Engine,
    create_engine,
    event,
)
from sqlalchemy.exc import (
    DataError,
    DBAPIError,
    IntegrityError,
    NotSupportedError,
    ProgrammingError,
)
from sqlalchemy.exc import TimeoutError as PoolTimeout

_BUSY_TIMEOUT_MS = 5_000
# A database that has vanished is noticed: seconds to connect, milliseconds to acknowledge (libpq).
_IN_TIME = {"connect_timeout": 5, "tcp_user_timeout": 10_000}
# Pages in SQLite's log, from which on a commit moves them into the database, which takes 5 ms and
# more: that is for what waits for the disk anyway, and for others only where nothing else comes.
_MOST_PAGES, _MOST_BY_OTHERS = 1000, 4000
_LEVEL, _NOTES = "synchronous", "notes"
# PostgreSQL's other levels all wait at least for its own disk.
_COMMITS_WAIT = (
    "SELECT set_config('synchronous_commit', 'on', false)"
    " WHERE current_setting('synchronous_commit') = 'off'"
)
_OURS = (DataError, IntegrityError, NotSupportedError, ProgrammingError)


class AskedFromLoop(RuntimeError):
    """A database was asked from a thread that runs an event loop: a fault of ours."""


def is_of_database(fault: BaseException) -> bool:
    """Return whether a fault is the database's (full, locked, gone), not of what was written."""
    is_its = isinstance(fault, DBAPIError) and not isinstance(fault, _OURS)
    return is_its or isinstance(fault, PoolTimeout)


def open_engine(url: str) -> Engine:
    """Return an engine for any SQLAlchemy URL; what it commits survives a power cut.

    SQLite runs in WAL mode: readers never wait for writers. PostgreSQL may end while we live, and
    then forgets what it has not written: a number of an event that was told would be given again.
    So there each commit waits, whatever its user has others do.
    """
    is_remote = not url.startswith("sqlite")
    arguments = _IN_TIME if url.startswith("postgresql") else {}
    engine = create_engine(url, pool_pre_ping=is_remote, connect_args=arguments)
    if engine.dialect.name == "sqlite":
        if engine.url.database:
            Path(engine.url.database).parent.mkdir(parents=True, exist_ok=True)

        def prepare(connection: Any, _: Any) -> None:
            for pragma in (
                f"busy_timeout={_BUSY_TIMEOUT_MS}",
                "journal_mode=WAL",
                "synchronous=FULL",
            ):
                connection.execute(f"PRAGMA {pragma}").close()

        event.listen(engine, "connect", prepare)
    if engine.dialect.name == "postgresql":

        def wait_for_commits(connection: Any, _: Any) -> None:
            connection.execute(_COMMITS_WAIT).close()
            connection.commit()

        event.listen(engine, "connect", wait_for_commits)
    return engine


def keep_off_loops(engine: Engine) -> None:
    """Refuse to ask a database from a thread that runs an event loop.

    A database makes one wait, for others and for the disk, and a loop that waits answers nothing.

    Raises:
        AskedFromLoop: Later, by whatever is asked there.
    """

    def refuse(*_: Any) -> None:
        if is_in_loop():
            message = "the database is asked in the event loop's thread, which must not wait"
            raise AskedFromLoop(message)

    # A connection is taken from the pool before anything is asked of it, and may be opened then.
    event.listen(engine, "do_connect", refuse)
    event.listen(engine, "before_cursor_execute", refuse)
    event.listen(engine, "commit", refuse)


def is_in_loop() -> bool:
    """Return whether this thread runs an event loop just now."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return True


async def ask[**P, T](question: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    """Ask a database in a thread; canceled, wait for its end: it has a connection until then."""
    work = asyncio.ensure_future(asyncio.to_thread(question, *args, **kwargs))
    try:
        return await asyncio.shield(work)
    except asyncio.CancelledError:
        await asyncio.wait({work})
        raise


def sync_log(engine: Engine) -> None:
    """Wait until the disk has what a database has committed; only SQLite leaves that to us.

    All that it has committed is in its write-ahead log, or on the disk (sqlite.org/wal.html). To
    write once more, durably, would do as well, but what changes nothing is not written at all.

    Raises:
        OSError: The disk does not take it.
    """
    if engine.dialect.name != "sqlite" or not engine.url.database:
        return
    with suppress(FileNotFoundError):
        log = os.open(f"{engine.url.database}-wal", os.O_RDONLY)
        try:
            os.fsync(log)
        finally:
            os.close(log)


def set_durability(connection: Connection, *, is_durable: bool) -> None:
    """Say whether the transaction that begins must survive a power cut, or only a crash of ours.

    Waiting for the disk takes milliseconds: what can be computed again need not wait. A later
    durable transaction makes durable all that came before it. Only SQLite gives the choice: what
    it has committed outlives us before the disk has it; for PostgreSQL see `open_engine`.
    """
    if connection.dialect.name != "sqlite":
        return
    level = "FULL" if is_durable else "NORMAL"
    most_pages = _MOST_PAGES if is_durable else _MOST_BY_OTHERS
    # The level of a driver's connection is kept beside it.
    if connection.info.get(_LEVEL) != level:
        # By the driver itself: SQLAlchemy takes twenty times as long, for every answer.
        cursor = connection.connection.cursor()
        cursor.execute(f"PRAGMA synchronous={level}")
        cursor.execute(f"PRAGMA wal_autocheckpoint={most_pages}").fetchall()
        cursor.close()
        connection.info[_LEVEL] = level


def begin_notes(connection: Connection) -> None:
    """Forget what was noted of earlier transactions of a connection."""
    connection.info[_NOTES] = {}


def in_transaction(connection: Connection, name: str) -> dict[str, Any]:
    """Return the notes of a name about the transaction that a connection is in."""
    return connection.info.setdefault(_NOTES, {}).setdefault(name, {})
