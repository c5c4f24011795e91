"""backup() and restore(): the records, which are all in the database, as one compressed file.

A backup is a copy of a SQLite database, compressed by gzip: `gunzip` makes a database of it that
any program can open. Databases of PostgreSQL have `pg_dump` for that.
"""

import gzip
import hashlib
import os
import shutil
import sqlite3
import tempfile
import zlib
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import make_url

from service.errors import BackupImpossible, BackupInvalid, RecordsExist
from service.jobs.errors import DatabaseTooNew
from service.jobs.store.sql.schema import NEWEST
from service.settings import Settings

# The first revision that has everything in the database.
_WHOLE = "0008"


@dataclass(frozen=True)
class Backup:
    """What is in a backup.

    Attributes:
        revision: Of the database.
        num_jobs: Plans, regions and executions.
        num_artifacts: Documents of scenes, and files that they were made from.
    """

    revision: str
    num_jobs: int
    num_artifacts: int


def backup(settings: Settings, target: Path) -> Backup:
    """Write a backup, while a server works or not.

    Args:
        settings: Of the server.
        target: The file to write; it is replaced at the end, whole.

    Raises:
        BackupImpossible: The database is not of SQLite, or an older version has left it.
        OSError: A file cannot be read or written; `FileNotFoundError` if there are no records.
        sqlite3.Error: The database cannot be read.
    """
    database = _database_file(settings)
    if not database.is_file():
        raise FileNotFoundError(2, "there are no records", str(database))
    with tempfile.TemporaryDirectory(dir=target.resolve().parent, prefix=".part") as name:
        copy, packed = Path(name) / "copy", Path(name) / "packed"
        _copy_database(database, copy)
        found = _look_at(copy)
        if found is None or found.revision < _WHOLE:
            message = f"an older version has left {database}, with files beside it: start the "
            message += "server of this version once, which stores them, and back up then"
            raise BackupImpossible(message, {"database": str(database)})
        with copy.open("rb") as plain, gzip.open(packed, "wb", compresslevel=6) as compressed:
            shutil.copyfileobj(plain, compressed)
        _sync(packed)
        packed.replace(target)
    return found


def restore(settings: Settings, source: Path) -> Backup:
    """Make a SQLite database of a backup; all of it is verified before.

    Raises:
        BackupImpossible: The settings name a database that is not of SQLite.
        BackupInvalid: The file is no backup, or damaged.
        DatabaseTooNew: A newer version has made it.
        OSError: A file cannot be read or written.
        RecordsExist: There are records already.
    """
    database = _database_file(settings)
    if database.exists():
        raise _records_exist(database)
    database.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=database.parent, prefix=".restored") as name:
        copy = Path(name) / "copy"
        found = _unpack(source, copy)
        _sync(copy)
        try:
            os.link(copy, database)  # unlike a rename it replaces nothing
        except FileExistsError:
            raise _records_exist(database) from None
    return found


def _database_file(settings: Settings) -> Path:
    """Return the file of a SQLite database.

    Raises:
        BackupImpossible: It is of another kind.
    """
    url = make_url(settings.url)
    if url.get_backend_name() != "sqlite" or not url.database:
        shown = url.set(drivername=url.get_backend_name()).render_as_string(hide_password=True)
        message = f"all records are in {shown}: its own tools back it up and restore it, such as "
        message += "pg_dump --format=custom and pg_restore, while servers work"
        raise BackupImpossible(message, {"database": shown})
    return Path(url.database).resolve()


def _copy_database(database: Path, copy: Path) -> None:
    """Copy a database that others may write to."""
    with closing(sqlite3.connect(database)) as source, closing(sqlite3.connect(copy)) as target:
        source.backup(target)
        target.execute("PRAGMA journal_mode=DELETE").close()


def _look_at(database: Path) -> Backup | None:
    """Return what is in a database; None if it has no revision."""
    with closing(sqlite3.connect(database)) as connection:
        names = {row[0] for row in connection.execute("SELECT name FROM sqlite_master")}
        if "alembic_version" not in names:
            return None
        (revision,) = connection.execute("SELECT version_num FROM alembic_version").fetchone()
        counts = [
            connection.execute(f"SELECT count(*) FROM {table}").fetchone()[0]  # noqa: S608
            if table in names
            else 0
            for table in ("jobs", "artifacts")
        ]
    return Backup(str(revision), *counts)


def _unpack(source: Path, copy: Path) -> Backup:
    """Unpack a backup, and return what is in it once all is verified."""
    try:
        with gzip.open(source) as packed, copy.open("wb") as plain:
            shutil.copyfileobj(packed, plain)
        found = _look_at(copy)
        if found is not None and found.revision > NEWEST:
            raise DatabaseTooNew.of(found.revision, NEWEST)
        wrong = "" if found is None else _find_damage(copy)
    except (EOFError, gzip.BadGzipFile, zlib.error, sqlite3.Error, TypeError) as fault:
        raise _invalid(source) from fault
    if found is None or wrong:
        raise _invalid(source, wrong)
    return found


def _find_damage(database: Path) -> str:
    """Return what is wrong with a database, empty if nothing is."""
    with closing(sqlite3.connect(database)) as connection:
        (state,) = connection.execute("PRAGMA integrity_check(1)").fetchone()
        if state != "ok":
            return str(state)
        # What version 0.1 stored as a file is named by the content of its scene.
        query = "SELECT digest, content FROM artifacts WHERE digest IS NOT world_digest"
        for digest, content in connection.execute(query):
            if hashlib.sha256(content).hexdigest() != digest:
                return f"artifact {digest}"
    return ""


def _sync(path: Path) -> None:
    with path.open("rb") as file:
        os.fsync(file.fileno())


def _invalid(source: Path, wrong: str = "") -> BackupInvalid:
    evidence = {"file": str(source)} | ({"member": wrong} if wrong else {})
    return BackupInvalid(f"{source} is no backup, or is damaged", evidence)


def _records_exist(database: Path) -> RecordsExist:
    message = f"there are records in {database}: restore into an empty data folder"
    return RecordsExist(message, {"database": str(database)})
