"""backup() and restore(): the records and the files that belong to them, as one archive.

What the records name was on the disk when they were copied, or is there since: the files are packed
before the records, and those that were missing then again after them. Nothing that was used within
an hour is removed (see `file_cleanup`), so no file is missed while a server works.
"""

import gzip
import hashlib
import json
import os
import re
import shutil
import sqlite3
import tarfile
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import closing, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, Any

from pydantic import BaseModel, ConfigDict
from sqlalchemy import make_url

from service.errors import BackupInvalid, RecordsExist
from service.jobs.errors import DatabaseTooNew
from service.jobs.store.schema import NEWEST
from service.settings import Settings
from service.versions import versions

_ARCHIVE, _MANIFEST, _DATABASE = "archive", "manifest.json", "database.sqlite"
# Copies that jobs which wait will read, and the bytes that scenes were made from. The rest of the
# data folder is made from these.
_FOLDERS = ("files/bytes", "scenes", "regions")
_NAME = re.compile(rf"(?:{'|'.join(_FOLDERS)})/[A-Za-z0-9_-][A-Za-z0-9_.-]*")
_MAX_MANIFEST, _CHUNK = 256 * 2**20, 2**20


class Manifest(BaseModel):
    """What is in a backup.

    Attributes:
        format: Of the archive.
        version: Of the program that made it.
        created_at: When it was begun (UTC).
        revision: Of the database, as far as it has one.
        data_dir: The data folder, to which paths in the records lead.
        sha256: Of every other member, by name.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    format: int = 1
    version: str
    created_at: datetime
    revision: str | None
    data_dir: str
    sha256: dict[str, str]

    @property
    def has_records(self) -> bool:
        """Whether the database is in it; one of PostgreSQL is not."""
        return _DATABASE in self.sha256


def backup(settings: Settings, target: Path) -> Manifest:
    """Write a backup, while a server works or not.

    Args:
        settings: Of the server.
        target: The file to write; it is replaced at the end, whole.

    Raises:
        OSError: A file cannot be read or written; `FileNotFoundError` if there are no records.
        sqlite3.Error: The database cannot be read.
    """
    data_dir, database = settings.data_dir.resolve(), database_file(settings)
    if database is not None and not database.is_file():
        raise FileNotFoundError(2, "there are no records", str(database))
    began = datetime.now(UTC)
    with tempfile.TemporaryDirectory(dir=target.resolve().parent, prefix=".part") as name:
        folder, revision = Path(name), None
        archive = folder / _ARCHIVE
        with tarfile.open(archive, "w:gz", compresslevel=6) as tar:
            packed = _Packed(tar)
            packed.add_files(data_dir)
            if database is not None:
                revision = _copy_database(database, folder / _DATABASE)
                packed.add(folder / _DATABASE, _DATABASE)
                packed.add_files(data_dir)
            manifest = Manifest(
                version=versions()["wayproof"],
                created_at=began,
                revision=revision,
                data_dir=str(data_dir),
                sha256=packed.sha256,
            )
            (folder / _MANIFEST).write_text(manifest.model_dump_json(indent=1), encoding="utf-8")
            tar.add(folder / _MANIFEST, _MANIFEST)
        _sync(archive)
        archive.replace(target)
    return manifest


def restore(settings: Settings, source: Path) -> Manifest:
    """Make a data folder, and a SQLite database, of a backup; all of it is verified before.

    Raises:
        BackupInvalid: The file is no backup, or damaged.
        DatabaseTooNew: A newer version has made it.
        OSError: A file cannot be read or written.
        RecordsExist: There are records already.
    """
    data_dir, database = settings.data_dir.resolve(), database_file(settings)
    if database is not None and database.exists():
        raise _records_exist(database)
    place = data_dir if database is None else database.parent
    for folder in (data_dir, place):
        folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=place, prefix=".restored") as name:
        folder = Path(name)
        manifest = _unpack(source, folder)
        for member in manifest.sha256:
            if member != _DATABASE:
                _move(folder / member, data_dir / member)
        if manifest.has_records and database is not None:
            _lead_to(folder / _DATABASE, manifest.data_dir, str(data_dir))
            _sync(folder / _DATABASE)
            try:
                os.link(folder / _DATABASE, database)  # unlike a rename it replaces nothing
            except FileExistsError:
                raise _records_exist(database) from None
    return manifest


def database_file(settings: Settings) -> Path | None:
    """Return the file of a SQLite database; None for one of another kind."""
    url = make_url(settings.url)
    if url.get_backend_name() != "sqlite" or not url.database:
        return None
    return Path(url.database).resolve()


class _Packed:
    """What is in an archive that is being written."""

    def __init__(self, tar: tarfile.TarFile) -> None:
        self.sha256: dict[str, str] = {}
        self._tar = tar

    def add_files(self, data_dir: Path) -> None:
        """Add the files of the data folder that are not in it; one that vanishes is not needed."""
        for folder in _FOLDERS:
            for file in sorted((data_dir / folder).glob("*")):
                name = f"{folder}/{file.name}"
                if name not in self.sha256 and _NAME.fullmatch(name) and file.is_file():
                    with suppress(FileNotFoundError):
                        self.add(file, name)

    def add(self, path: Path, name: str) -> None:
        """Add a file."""
        with path.open("rb") as file:
            known = self._tar.gettarinfo(arcname=name, fileobj=file)
            self.sha256[name] = hashlib.file_digest(file, "sha256").hexdigest()
            file.seek(0)
            self._tar.addfile(known, file)


def _copy_database(database: Path, copy: Path) -> str | None:
    """Copy a database that others may write to, and return its revision."""
    with closing(sqlite3.connect(database)) as source, closing(sqlite3.connect(copy)) as target:
        source.backup(target)
        target.execute("PRAGMA journal_mode=DELETE").close()
        known = "SELECT count(*) FROM sqlite_master WHERE name = 'alembic_version'"
        if not target.execute(known).fetchone()[0]:
            return None
        row = target.execute("SELECT version_num FROM alembic_version").fetchone()
        return None if row is None else str(row[0])


def _unpack(source: Path, folder: Path) -> Manifest:
    """Unpack an archive into an empty folder, and return its manifest once all is verified."""
    found: dict[str, str] = {}
    content: bytes | None = None
    try:
        with gzip.open(source) as raw, tarfile.open(fileobj=raw, mode="r:") as tar:
            for name, file in _members(tar):
                if name == _MANIFEST:
                    content = file.read(_MAX_MANIFEST)
                else:
                    found[name] = _write(file, folder / name)
            while raw.read(_CHUNK):  # to the checksum at its end
                pass
        manifest = Manifest.model_validate_json(content or b"")
    except (tarfile.TarError, EOFError, gzip.BadGzipFile, ValueError, zlib.error) as fault:
        message = f"{source} is no backup, or is damaged"
        raise BackupInvalid(message, {"file": str(source)}) from fault
    _verify(manifest, found, source)
    return manifest


def _members(tar: tarfile.TarFile) -> Iterator[tuple[str, IO[bytes]]]:
    """Return the members by name.

    Raises:
        ValueError: One is none that `backup` writes.
    """
    for member in tar:
        is_ours = member.name in {_MANIFEST, _DATABASE} or _NAME.fullmatch(member.name)
        file = tar.extractfile(member) if member.isreg() and is_ours else None
        if file is None:
            raise ValueError(member.name)
        yield member.name, file


def _write(content: IO[bytes], path: Path) -> str:
    """Write a file that is not there yet, and return its sha256."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("x+b") as file:
        shutil.copyfileobj(content, file)
        file.seek(0)
        return hashlib.file_digest(file, "sha256").hexdigest()


def _verify(manifest: Manifest, found: dict[str, str], source: Path) -> None:
    if manifest.format != 1 or (manifest.revision or "") > NEWEST:
        raise DatabaseTooNew.of(manifest.revision or "unknown", NEWEST)
    wrong = sorted(dict(manifest.sha256.items() ^ found.items()))
    named = (name for name in found if name.startswith("files/bytes/"))
    wrong += [name for name in named if Path(name).name != found[name]]
    if wrong:
        message = f"{source} is damaged: {wrong[0]!r} is not what was packed"
        raise BackupInvalid(message, {"file": str(source), "member": wrong[0]})


def _lead_to(database: Path, old: str, new: str) -> None:
    """Have the paths in records of jobs lead to another data folder."""
    if old == new:
        return
    begins = {"old": json.dumps(old)[:-1] + "/", "new": json.dumps(new)[:-1] + "/"}
    known = "SELECT name FROM sqlite_master WHERE name IN "
    known += "('job_bodies', 'job_summaries', 'job_briefs')"
    with closing(sqlite3.connect(database)) as connection, connection:
        for (table,) in connection.execute(known).fetchall():
            moved = f"UPDATE {table} SET payload = replace(payload, :old, :new)"  # noqa: S608
            connection.execute(f"{moved} WHERE instr(payload, :old)", begins)


def _move(path: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.move(path, target)
    _sync(target)


def _sync(path: Path) -> None:
    with path.open("rb") as file:
        os.fsync(file.fileno())


def _records_exist(database: Path) -> RecordsExist:
    message = f"there are records in {database}: restore into an empty data folder"
    evidence: dict[str, Any] = {"database": str(database)}
    return RecordsExist(message, evidence)
