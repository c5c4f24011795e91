"""SceneStore: scenes survive the server."""

import json
import os
import secrets
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from sqlalchemy import Engine, Row, delete, insert, select

from service.errors import UnknownResource
from service.scenes.records import SceneRecord, metadata, scenes


class SceneStore:
    """Scenes in the database; their documents also as files, which is where slots read them.

    The files are a copy, named by content: written before they are needed, and again if lost. They
    outlive their scene, because plans that were made in it can still be replayed.
    """

    def __init__(self, engine: Engine, folder: Path) -> None:
        """Keep records in `engine` and files in `folder`; call `open` before use."""
        self._engine = engine
        self._folder = folder

    def open(self) -> None:
        """Create what is missing."""
        metadata.create_all(self._engine)
        self._folder.mkdir(parents=True, exist_ok=True)

    def add(
        self, name: str, digest: str, document: dict[str, Any], summary: dict[str, Any]
    ) -> SceneRecord:
        """Record a new scene."""
        row: dict[str, Any] = {
            "id": f"scn_{secrets.token_hex(8)}",
            "revision": 1,
            "digest": digest,
            "name": name,
            "created_at": datetime.now(UTC).isoformat(),
            "document": document,
            "summary": summary,
        }
        self._write(digest, document)
        with self._engine.begin() as connection:
            connection.execute(insert(scenes).values(row))
        return self.get(row["id"])

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
        """Return scenes older than the serial `before`, newest first."""
        query = select(scenes).order_by(scenes.c.serial.desc()).limit(limit)
        if before is not None:
            query = query.where(scenes.c.serial < before)
        with self._engine.connect() as connection:
            return [_record(row) for row in connection.execute(query)]

    def delete(self, identifier: str) -> None:
        """Forget a scene; plans that were made in it stay.

        Raises:
            UnknownResource: There is none.
        """
        with self._engine.begin() as connection:
            gone = connection.execute(delete(scenes).where(scenes.c.id == identifier))
        if gone.rowcount == 0:
            raise UnknownResource.of("scene", identifier)

    def file(self, record: SceneRecord) -> Path:
        """Return the file of a scene's document, written again if it was lost."""
        path = self._path(record.digest)
        if not path.is_file():
            self._write(record.digest, record.document)
        return path

    def _path(self, digest: str) -> Path:
        return (self._folder / f"{digest}.json").resolve()

    def _write(self, digest: str, document: dict[str, Any]) -> None:
        """Write the document whole or not at all."""
        handle, temporary = tempfile.mkstemp(dir=self._folder)
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            json.dump(document, file)
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).replace(self._path(digest))


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
