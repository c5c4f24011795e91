"""SceneStore: scenes survive the server."""

import json
import secrets
from collections.abc import Generator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from threading import Lock
from typing import Any

from sqlalchemy import Connection, Engine, Row, delete, func, insert, select

from planning.whole_files import write_durably
from service.errors import RevisionConflict, UnknownResource
from service.jobs.database import set_durability
from service.scenes.records import SceneRecord, metadata, scenes


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

    def open(self) -> None:
        """Create what is missing."""
        metadata.create_all(self._engine)
        for index in scenes.indexes:  # that a table of an older version lacks
            index.create(self._engine, checkfirst=True)
        self._folder.mkdir(parents=True, exist_ok=True)

    def add(
        self, name: str, digest: str, document: dict[str, Any], summary: dict[str, Any]
    ) -> SceneRecord:
        """Record a new scene."""
        identifier = f"scn_{secrets.token_hex(8)}"
        row = _row(identifier, 1, {"name": name, "digest": digest}, document, summary)
        self._write(digest, document, summary)
        with self._writing() as connection:
            connection.execute(insert(scenes).values(row))
        return self.get(identifier)

    def revise(
        self,
        base: SceneRecord,
        name: str,
        digest: str,
        document: dict[str, Any],
        summary: dict[str, Any],
    ) -> SceneRecord:
        """Record the revision that follows `base`.

        Raises:
            UnknownResource: The scene is gone.
            RevisionConflict: `base` has a successor already.
        """
        row = _row(base.id, base.revision + 1, {"name": name, "digest": digest}, document, summary)
        self._write(digest, document, summary)
        newest = select(func.max(scenes.c.revision)).where(scenes.c.id == base.id)
        # One server works on a database, so a lock in this process keeps writers apart.
        with self._revising, self._writing() as connection:
            latest = connection.execute(newest).scalar()
            if latest is None:
                raise UnknownResource.of("scene", base.id)
            if latest != base.revision:
                raise RevisionConflict.of(base.id, base.revision, latest)
            connection.execute(insert(scenes).values(row))
        return self.get(base.id, base.revision + 1)

    def get(self, identifier: str, revision: int | None = None) -> SceneRecord:
        """Return a revision of a scene, by default the latest.

        Raises:
            UnknownResource: There is none.
        """
        query = select(scenes).where(scenes.c.id == identifier)
        with self._engine.connect() as connection:
            found = connection.execute(query.order_by(scenes.c.revision.desc())).first()
            if found is not None and revision not in {None, found.revision}:
                wanted = query.where(scenes.c.revision == revision)
                found = connection.execute(wanted).first()
                if found is None:
                    raise UnknownResource.of("revision", f"{identifier}/{revision}")
        if found is None:
            raise UnknownResource.of("scene", identifier)
        return _record(found)

    def page(self, limit: int, before: int | None) -> list[SceneRecord]:
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
        columns = [column for column in scenes.c if column is not scenes.c.serial]
        query = select(first.c.serial, *columns).select_from(first).join(scenes, is_latest)
        query = query.order_by(first.c.serial.desc())
        with self._engine.connect() as connection:
            return [_record(row) for row in connection.execute(query)]

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
            self._write(record.digest, record.document, record.summary)
        return path

    @contextmanager
    def _writing(self) -> Generator[Connection]:
        """Write what survives a power cut: connections are shared with what need not."""
        with self._engine.begin() as connection:
            set_durability(connection, is_durable=True)
            yield connection

    def path(self, digest: str) -> Path:
        """Return where the file of a document is, or would be."""
        return self._folder / f"{digest}.json"

    def _write(self, digest: str, document: dict[str, Any], summary: dict[str, Any]) -> None:
        """Write the document and what its files are, whole or not at all."""
        written = {"document": document}
        if "files" in summary:  # not in those of servers that kept no files
            written["files"] = summary["files"]
        write_durably(self.path(digest), json.dumps(written).encode())


def _row(
    identifier: str,
    revision: int,
    named: dict[str, str],
    document: dict[str, Any],
    summary: dict[str, Any],
) -> dict[str, Any]:
    created_at = datetime.now(UTC).isoformat()
    return {
        **named,
        "id": identifier,
        "revision": revision,
        "created_at": created_at,
        "document": document,
        "summary": summary,
    }


def _record(row: Row[Any]) -> SceneRecord:
    return SceneRecord(
        serial=row.serial,
        id=row.id,
        revision=row.revision,
        digest=row.digest,
        name=row.name,
        created_at=datetime.fromisoformat(row.created_at),
        document=row.document,
        summary=row.summary,
    )
