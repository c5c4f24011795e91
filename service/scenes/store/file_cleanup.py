"""Sweeper: artifacts that no scene and no job needs any more are removed, and their copies."""

import asyncio
import logging
import shutil
from collections.abc import Iterator
from contextlib import suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path

from anyio import to_thread
from sqlalchemy import Connection, Engine, select

from planning.domain.value import digest
from service.jobs.host_folder import files_folder
from service.jobs.store.artifact_store import ArtifactStore, read_content
from service.jobs.store.sql.tables import artifacts
from service.scenes.store.document_artifact import files_of
from service.scenes.store.records import scenes

# What was touched so lately may be of a scene that is being loaded [s].
GRACE = 3600.0
# A plan that waits since then may read it yet [s].
_FORMER_GRACE = 24 * 3600.0
# Between two sweeps [s].
_PAUSE = 60.0
_OWNER = "owner.txt"
_log = logging.getLogger(__name__)


class Sweeper:
    """Sweeps when it is asked to, in a thread, and not too often."""

    def __init__(self, engine: Engine, data_dir: Path, owner: str) -> None:
        """Sweep `data_dir`, whose records are in `engine`; `owner` tells databases apart."""
        self._engine = engine
        self._data_dir = data_dir
        self._owner = owner
        self._asked = asyncio.Event()

    def ask(self) -> None:
        """Have it sweep soon."""
        self._asked.set()

    async def run(self) -> None:
        """Sweep whenever asked, until canceled."""
        while True:
            await self._asked.wait()
            self._asked.clear()
            try:
                await to_thread.run_sync(self._sweep)
            except Exception:  # noqa: BLE001  (no sweep is worth more than what it sweeps for)
                _log.exception("the data folder could not be swept")
            await asyncio.sleep(_PAUSE)

    def _sweep(self) -> None:
        if _is_owner(files_folder(self._data_dir), self._owner):
            sweep(self._engine, self._data_dir)
        else:
            _log.warning("the files of %s are another database's: not swept", self._data_dir)


def sweep(engine: Engine, data_dir: Path, grace: float = GRACE) -> None:
    """Remove artifacts that no scene and no job of a database needs, and what was made of them.

    Args:
        engine: Of the records.
        data_dir: With the copies of artifacts.
        grace: What was touched so lately stays [s].
    """
    before = datetime.now(UTC) - timedelta(seconds=grace)
    with engine.begin() as connection:
        of_scenes = connection.execute(select(scenes.c.digest).distinct()).scalars().all()
        ArtifactStore(engine).sweep(connection, of_scenes, before)
    with engine.connect() as connection:
        stored = set(connection.execute(select(artifacts.c.digest)).scalars())
        folders = set(_folders(connection))
    files = files_folder(data_dir)
    _remove(files / "bytes", stored, before.timestamp())
    _remove(files / "folders", folders, before.timestamp())
    # Documents and regions that version 0.1 kept there; what is needed of them is stored by now.
    for former in ("scenes", "regions"):
        _remove(data_dir / former, set(), before.timestamp() - _FORMER_GRACE)


def _folders(connection: Connection) -> Iterator[str]:
    """Yield the names of the folders that are made of files of stored scenes."""
    whole = select(artifacts.c.digest).where(artifacts.c.world_digest.is_not(None))
    for name in connection.execute(whole).scalars().all():
        for kept in files_of(read_content(connection, name) or b"").values():
            yield digest(dict(kept["sha256"]))


def _remove(folder: Path, needed: set[str], before: float) -> None:
    for entry in folder.glob("*"):
        if entry.name not in needed and _is_old(entry, before):
            if entry.is_dir():
                shutil.rmtree(entry, ignore_errors=True)
            else:
                entry.unlink(missing_ok=True)


def _is_old(entry: Path, before: float) -> bool:
    with suppress(FileNotFoundError):
        return entry.stat().st_mtime < before
    return False


def _is_owner(folder: Path, owner: str) -> bool:
    """Return whether a folder is this database's; one that is no database's becomes so."""
    marker = folder / _OWNER
    if not marker.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        marker.write_text(owner, encoding="utf-8")
    return marker.read_text(encoding="utf-8") == owner
