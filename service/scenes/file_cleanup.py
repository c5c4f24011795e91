"""Sweeper: files that no scene and no job needs any more are removed from the data folder."""

import asyncio
import json
import logging
import shutil
from collections.abc import Iterable, Mapping
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from anyio import to_thread
from sqlalchemy import Engine, select

from planning.domain.value import digest
from service.jobs.store.tables import jobs
from service.scenes.records import scenes

# What was touched so lately may be of a scene that is being loaded [s].
GRACE = 3600.0
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
        if _is_owner(self._data_dir / "files", self._owner):
            sweep(self._engine, self._data_dir)
        else:
            _log.warning("the files of %s are another database's: not swept", self._data_dir)


def sweep(engine: Engine, data_dir: Path, grace: float = GRACE) -> None:
    """Remove documents, bytes and folders that no scene and no job of a database needs.

    Args:
        engine: Of the records.
        data_dir: With `scenes` and `files`.
        grace: What was touched so lately stays [s].
    """
    before = datetime.now(UTC).timestamp() - grace
    needed = _needed(engine)
    kept: list[Mapping[str, Any]] = []
    known: set[str] = set()
    for document in (data_dir / "scenes").glob("*.json"):
        if document.stem in needed or not _is_old(document, before):
            known.add(document.stem)
            kept += _files_in(document)
        else:
            document.unlink(missing_ok=True)
    # What is half written was left by a server that was killed.
    _remove(data_dir / "scenes", {f"{name}.json" for name in known}, before)
    kept += _files_of_rows(engine, known)
    sha256s = {sha256 for files in kept for sha256 in files["sha256"].values()}
    folders = {digest(dict(files["sha256"])) for files in kept}
    _remove((data_dir / "files" / "bytes"), sha256s, before)
    _remove((data_dir / "files" / "folders"), folders, before)


def _needed(engine: Engine) -> set[str]:
    with engine.connect() as connection:
        of_scenes = connection.execute(select(scenes.c.digest).distinct()).scalars().all()
        of_jobs = connection.execute(select(jobs.c.world_digest).distinct()).scalars().all()
    return {found for found in (*of_scenes, *of_jobs) if found is not None}


def _files_of_rows(engine: Engine, known: set[str]) -> Iterable[Mapping[str, Any]]:
    """Return the files of scenes whose documents are not on the disk just now."""
    query = select(scenes.c.digest, scenes.c.summary["files"])
    with engine.connect() as connection:
        for found, files in connection.execute(query):
            if found not in known:
                yield from (files or {}).values()


def _files_in(document: Path) -> list[Mapping[str, Any]]:
    try:
        written = json.loads(document.read_text(encoding="utf-8"))
        return list(written["files"].values())
    except (OSError, ValueError, KeyError, AttributeError):
        return []


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
