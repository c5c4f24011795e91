"""Rows of the table of scenes: what is read and written in a connection."""

import json
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    JSON,
    Connection,
    Row,
    Select,
    Text,
    cast,
    delete,
    func,
    insert,
    literal,
    select,
    update,
)

from service.errors import UnknownResource
from service.jobs.errors import IdempotencyConflict
from service.jobs.job import IdempotencyKey
from service.jobs.json_text import Encoded, encode
from service.jobs.store.artifact_store import read_content
from service.scenes.models.scene import SceneSummary
from service.scenes.models.summary import Group
from service.scenes.store.document_artifact import document_of
from service.scenes.store.records import SceneBrief, SceneRecord, scenes
from service.scenes.tasks import LoadedScene

# Member of a row's summary: the revision that has what this row leaves out.
_HELD = "unchecked_in"
_LEFT_OUT = {scenes.c.summary, scenes.c.key, scenes.c.request_digest}
_BRIEF = tuple(column for column in scenes.c if column not in _LEFT_OUT)


def insert_revision(
    connection: Connection,
    identifier: str,
    revision: int,
    loaded: LoadedScene,
    artifact: str,
    unchecked_in: int | None = None,
) -> SceneRecord:
    """Return the record of a new row, whose document is an artifact."""
    # A server that kept no files wrote no member for them.
    summary = loaded.summary.model_dump_json(
        ensure_ascii=True, exclude={"files"} if loaded.summary.files is None else None
    )
    unchecked = f'"unchecked":{loaded.unchecked.text}'
    if unchecked_in is not None:
        unchecked = f'"{_HELD}":{unchecked_in}'
    created_at = datetime.now(UTC)
    row = {
        "id": identifier,
        "revision": revision,
        "digest": loaded.digest,
        "artifact": artifact,
        "summary": _as_json(connection, f"{summary[:-1]},{unchecked}}}"),
        "name": loaded.name,
        "created_at": created_at.isoformat(),
    }
    done = connection.execute(insert(scenes).values(**row).returning(scenes.c.serial))
    serial = int(done.scalar_one())
    content = loaded.digest, artifact, loaded.name
    brief = SceneBrief(serial, identifier, revision, *content, created_at)
    return SceneRecord(**vars(brief), loaded=loaded, unchecked_in=unchecked_in)


def write_key(connection: Connection, identifier: str, key: IdempotencyKey) -> None:
    """Write the idempotency key of the request that posted a scene.

    Raises:
        IntegrityError: Another scene has the key.
    """
    row = update(scenes).where(scenes.c.id == identifier)
    connection.execute(row.values(key=key.text, request_digest=key.digest))


def find_by_key(connection: Connection, key: IdempotencyKey) -> str | None:
    """Return the id of the scene that an idempotency key names, None if there is none.

    Raises:
        IdempotencyConflict: The key was used for another request.
    """
    query = select(scenes.c.id, scenes.c.request_digest).where(scenes.c.key == key.text)
    found = connection.execute(query).first()
    if found is not None and found.request_digest != key.digest:
        raise IdempotencyConflict.of(key.text or "", "scene", found.id)
    return None if found is None else found.id


def lock(connection: Connection, identifier: str) -> None:
    """Keep other servers from changing a scene until the transaction ends, where there are any.

    Its first revision, which stays as long as the scene, stands for it: a row that is added while
    this waits for others is seen by what is read after it.
    """
    if connection.dialect.name != "sqlite":
        first = select(scenes.c.serial).where(scenes.c.id == identifier, scenes.c.revision == 1)
        connection.execute(first.with_for_update())


def latest_revision(connection: Connection, identifier: str) -> int | None:
    """Return the number of the latest revision of a scene, None if there is no such scene."""
    newest = select(func.max(scenes.c.revision)).where(scenes.c.id == identifier)
    return connection.execute(newest).scalar()


def read_brief(connection: Connection, identifier: str, revision: int | None) -> SceneBrief:
    """Return a revision of a scene, by default the latest, without its content.

    Raises:
        UnknownResource: There is none.
    """
    query = select(*_BRIEF).where(scenes.c.id == identifier)
    found = connection.execute(query.order_by(scenes.c.revision.desc()).limit(1)).first()
    if found is None:
        raise UnknownResource.of("scene", identifier)
    if revision not in {None, found.revision}:
        found = connection.execute(query.where(scenes.c.revision == revision)).first()
        if found is None:
            raise UnknownResource.of("revision", f"{identifier}/{revision}")
    return _brief(found)


def read_record(connection: Connection, brief: SceneBrief) -> SceneRecord:
    """Return a record whose brief was read.

    Raises:
        UnknownResource: The scene is gone.
    """
    content = read_content(connection, brief.artifact)
    if content is None:  # it goes with the scene, some time after it
        raise UnknownResource.of("scene", brief.id)
    found: dict[str, Any] = json.loads(_summary(connection, brief.id, brief.revision))
    unchecked, held = found.pop("unchecked", []), found.pop(_HELD, None)
    if held is not None:
        unchecked = json.loads(_summary(connection, brief.id, held))["unchecked"]
    loaded = LoadedScene(
        name=brief.name,
        digest=brief.digest,
        summary=SceneSummary.model_validate(found),
        unchecked=Encoded(encode(unchecked)),
        document=document_of(content),
    )
    return SceneRecord(**vars(brief), loaded=loaded, unchecked_in=held)


def read_groups(connection: Connection, identifier: str) -> list[Group]:
    """Return the groups of a scene, none if it is gone."""
    revision = latest_revision(connection, identifier)
    if revision is None:
        return []
    found = json.loads(_summary(connection, identifier, revision))
    return SceneSummary.model_validate({"groups": found.get("groups", [])}).groups


def read_page(
    connection: Connection, limit: int, before: int | None, name: str | None = None
) -> list[SceneBrief]:
    """Return the latest revision of scenes older than `before`, newest scene first.

    With a `name`, of those of that name alone: no edit changes it.

    A scene is as old as its first revision, whose serial stands for it: pages join up whatever is
    revised meanwhile.
    """
    return [_brief(row) for row in connection.execute(_page(limit, before, name))]


def _page(limit: int, before: int | None, name: str | None) -> Select[Any]:
    firsts = select(scenes.c.id, scenes.c.serial).where(scenes.c.revision == 1)
    if name is not None:
        firsts = firsts.where(scenes.c.name == name)
    firsts = firsts.order_by(scenes.c.serial.desc()).limit(limit)
    if before is not None:
        firsts = firsts.where(scenes.c.serial < before)
    first, other = firsts.subquery(), scenes.alias()
    latest = select(func.max(other.c.revision)).where(other.c.id == first.c.id)
    is_latest = (scenes.c.id == first.c.id) & (scenes.c.revision == latest.scalar_subquery())
    columns = [column for column in _BRIEF if column is not scenes.c.serial]
    query = select(first.c.serial, *columns).select_from(first).join(scenes, is_latest)
    return query.order_by(first.c.serial.desc())


def delete_rows(connection: Connection, identifier: str) -> None:
    """Delete all revisions of a scene.

    Raises:
        UnknownResource: There is none.
    """
    gone = connection.execute(delete(scenes).where(scenes.c.id == identifier))
    if gone.rowcount == 0:
        raise UnknownResource.of("scene", identifier)


def _as_json(connection: Connection, text: str) -> Any:
    """Return what a column of JSON takes for a text that is JSON already."""
    written = literal(text, Text)
    return cast(written, JSON) if connection.dialect.name == "postgresql" else written


def _summary(connection: Connection, identifier: str, revision: int) -> str:
    """Return the summary of a row as text.

    Raises:
        UnknownResource: The scene is gone.
    """
    wanted = (scenes.c.id == identifier) & (scenes.c.revision == revision)
    summary = connection.execute(select(cast(scenes.c.summary, Text)).where(wanted)).scalar()
    if summary is None:
        raise UnknownResource.of("scene", identifier)
    return summary


def _brief(row: Row[Any]) -> SceneBrief:
    return SceneBrief(
        serial=row.serial,
        id=row.id,
        revision=row.revision,
        digest=row.digest,
        artifact=row.artifact,
        name=row.name,
        created_at=datetime.fromisoformat(row.created_at),
    )
