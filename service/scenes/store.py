"""SceneStore: scenes survive the server."""

import json
import secrets
from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from threading import Lock
from typing import Any

from sqlalchemy import (
    JSON,
    Connection,
    Engine,
    Row,
    Text,
    cast,
    delete,
    func,
    insert,
    literal,
    select,
)
from sqlalchemy.exc import DBAPIError

from planning.parallel.atomic_files import write_durably
from service.errors import RevisionConflict, UnknownResource
from service.jobs.database import set_durability
from service.jobs.json_text import Encoded, encode
from service.scenes.recent import RecentScenes
from service.scenes.records import LoadedScene, SceneBrief, SceneRecord, metadata, scenes

# Member of a row's summary: the revision that has what this row leaves out.
_HELD = "unchecked_in"
_CONTENT = (scenes.c.document, scenes.c.summary)
_BRIEF = tuple(column for column in scenes.c if column not in {*_CONTENT})


class SceneStore:
    """Scenes in the database; their documents also as files, which is where slots read them.

    The files are a copy, named by content: written before they are needed, and again if lost. They
    outlive their scene, because plans that were made in it can still be replayed.
    """

    def __init__(self, engine: Engine, folder: Path) -> None:
        """Keep records in `engine` and files in `folder`; call `open` before use."""
        self._engine = engine
        self._folder = folder.resolve()
        self._revising = Lock()
        self._recent = RecentScenes()
        self._beside = ThreadPoolExecutor(1, "scene-files")

    def open(self) -> None:
        """Create what is missing."""
        metadata.create_all(self._engine)
        for index in scenes.indexes:  # that a table of an older version lacks
            index.create(self._engine, checkfirst=True)
        self._folder.mkdir(parents=True, exist_ok=True)

    def add(self, loaded: LoadedScene) -> SceneRecord:
        """Record a new scene."""
        with self._recording(loaded) as connection:
            record = _inserted(connection, f"scn_{secrets.token_hex(8)}", 1, loaded)
        self._recent.put(record)
        return record

    def revise(self, base: SceneBrief, loaded: LoadedScene) -> SceneRecord:
        """Record the revision that follows `base`.

        Raises:
            UnknownResource: The scene is gone.
            RevisionConflict: `base` has a successor already.
        """
        newest = select(func.max(scenes.c.revision)).where(scenes.c.id == base.id)
        # One server works on a database, so a lock in this process keeps writers apart.
        with self._revising, self._recording(loaded) as connection:
            latest = connection.execute(newest).scalar()
            if latest is None:
                raise UnknownResource.of("scene", base.id)
            if latest != base.revision:
                raise RevisionConflict.of(base.id, base.revision, latest)
            loaded, unchecked_in = self._sharing(base, loaded)
            record = _inserted(connection, base.id, latest + 1, loaded, unchecked_in)
        self._recent.put(record)
        return record

    def get(self, identifier: str, revision: int | None = None) -> SceneRecord:
        """Return a revision of a scene, by default the latest.

        Raises:
            UnknownResource: There is none.
        """
        query = select(*_BRIEF).where(scenes.c.id == identifier)
        with self._engine.connect() as connection:
            latest = query.order_by(scenes.c.revision.desc()).limit(1)
            found = connection.execute(latest).first()
            if found is None:
                raise UnknownResource.of("scene", identifier)
            if revision not in {None, found.revision}:
                wanted = query.where(scenes.c.revision == revision)
                found = connection.execute(wanted).first()
                if found is None:
                    raise UnknownResource.of("revision", f"{identifier}/{revision}")
            known = self._recent.get(identifier, found.revision)
            record = known or _read(connection, _brief(found))
        self._recent.put(record)
        return record

    def page(self, limit: int, before: int | None) -> list[SceneBrief]:
        """Return the latest revision of scenes older than `before`, newest scene first.

        A scene is as old as its first revision, whose serial stands for it: pages join up
        whatever is revised meanwhile.
        """
        firsts = select(scenes.c.id, scenes.c.serial).where(scenes.c.revision == 1)
        firsts = firsts.order_by(scenes.c.serial.desc()).limit(limit)
        if before is not None:
            firsts = firsts.where(scenes.c.serial < before)
        first, other = firsts.subquery(), scenes.alias()
        latest = select(func.max(other.c.revision)).where(other.c.id == first.c.id)
        is_latest = (scenes.c.id == first.c.id) & (scenes.c.revision == latest.scalar_subquery())
        columns = [column for column in _BRIEF if column is not scenes.c.serial]
        query = select(first.c.serial, *columns).select_from(first).join(scenes, is_latest)
        query = query.order_by(first.c.serial.desc())
        with self._engine.connect() as connection:
            return [_brief(row) for row in connection.execute(query)]

    def delete(self, identifier: str) -> None:
        """Forget a scene; plans that were made in it stay.

        Raises:
            UnknownResource: There is none.
        """
        with self._writing() as connection:
            gone = connection.execute(delete(scenes).where(scenes.c.id == identifier))
        if gone.rowcount == 0:
            raise UnknownResource.of("scene", identifier)

    def file(self, record: SceneRecord) -> Path:
        """Return the file of a scene's document, written again if it was lost."""
        path = self.path(record.digest)
        if not path.is_file():
            self._write(record.loaded)
        return path

    def _sharing(self, base: SceneBrief, loaded: LoadedScene) -> tuple[LoadedScene, int | None]:
        """Return what follows a revision, and which one's row has its unchecked pairs already.

        What an edit moves mostly does not change them, and of many objects they are half of it all.
        """
        before = self._recent.get(base.id, base.revision)
        if before is None or before.loaded.unchecked != loaded.unchecked:
            return loaded, None
        held = before.revision if before.unchecked_in is None else before.unchecked_in
        return replace(loaded, unchecked=before.loaded.unchecked), held

    @contextmanager
    def _recording(self, loaded: LoadedScene) -> Generator[Connection]:
        """Write a row while another thread writes the file, and commit once it has.

        Raises:
            OSError: The file cannot be written; there is no row then.
        """
        file = self._beside.submit(self._write, loaded)
        try:
            with self._writing() as connection:
                yield connection
                file.result()
        except DBAPIError:
            file.result()  # a full disk refuses both, and says so better
            raise

    @contextmanager
    def _writing(self) -> Generator[Connection]:
        """Write what survives a power cut: connections are shared with what need not."""
        with self._engine.begin() as connection:
            set_durability(connection, is_durable=True)
            yield connection

    def path(self, digest: str) -> Path:
        """Return where the file of a document is, or would be."""
        return self._folder / f"{digest}.json"

    def _write(self, loaded: LoadedScene) -> None:
        """Write the document and what its files are, whole or not at all."""
        written = f'{{"document":{loaded.document.text}'
        if "files" in loaded.summary:  # not in those of servers that kept no files
            written += f',"files":{encode(loaded.summary["files"])}'
        write_durably(self.path(loaded.digest), f"{written}}}".encode())


def _inserted(
    connection: Connection,
    identifier: str,
    revision: int,
    loaded: LoadedScene,
    unchecked_in: int | None = None,
) -> SceneRecord:
    """Return the record of a new row."""
    summary = encode(loaded.summary)[:-1] + ("," if loaded.summary else "")
    unchecked = f'"unchecked":{loaded.unchecked.text}'
    if unchecked_in is not None:
        unchecked = f'"{_HELD}":{unchecked_in}'
    texts = {"document": loaded.document.text, "summary": f"{summary}{unchecked}}}"}
    created_at = datetime.now(UTC)
    row = {
        "id": identifier,
        "revision": revision,
        "digest": loaded.digest,
        "name": loaded.name,
        "created_at": created_at.isoformat(),
    }
    written = {name: _as_json(connection, text) for name, text in texts.items()}
    done = connection.execute(insert(scenes).values(**row, **written).returning(scenes.c.serial))
    serial = int(done.scalar_one())
    brief = SceneBrief(serial, identifier, revision, loaded.digest, loaded.name, created_at)
    return SceneRecord(**vars(brief), loaded=loaded, unchecked_in=unchecked_in)


def _as_json(connection: Connection, text: str) -> Any:
    """Return what a column of JSON takes for a text that is JSON already."""
    written = literal(text, Text)
    return cast(written, JSON) if connection.dialect.name == "postgresql" else written


def _read(connection: Connection, brief: SceneBrief) -> SceneRecord:
    """Return a record whose brief was read.

    Raises:
        UnknownResource: The scene is gone.
    """
    document, summary = _texts(connection, brief.id, brief.revision)
    found: dict[str, Any] = json.loads(summary)
    unchecked, held = found.pop("unchecked", []), found.pop(_HELD, None)
    if held is not None:
        unchecked = json.loads(_texts(connection, brief.id, held)[1])["unchecked"]
    told = Encoded(encode(unchecked))
    loaded = LoadedScene(brief.name, brief.digest, Encoded(document), found, told)
    return SceneRecord(**vars(brief), loaded=loaded, unchecked_in=held)


def _texts(connection: Connection, identifier: str, revision: int) -> tuple[str, str]:
    """Return the content of a row as text: its document and its summary.

    Raises:
        UnknownResource: The scene is gone.
    """
    texts = [cast(column, Text).label(column.name) for column in _CONTENT]
    wanted = (scenes.c.id == identifier) & (scenes.c.revision == revision)
    row = connection.execute(select(*texts).where(wanted)).first()
    if row is None:
        raise UnknownResource.of("scene", identifier)
    return row.document, row.summary


def _brief(row: Row[Any]) -> SceneBrief:
    return SceneBrief(
        serial=row.serial,
        id=row.id,
        revision=row.revision,
        digest=row.digest,
        name=row.name,
        created_at=datetime.fromisoformat(row.created_at),
    )
