"""Documents of scenes become artifacts, and jobs name them by digest instead of by a path."""

import hashlib
import json
import re
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"

# A path of version 0.1 in the payload of a job: its file was named by the content of the scene.
_PATH = re.compile(r'("document": ?")[^"]*?([0-9a-f]{64})\.json(")')
_AT_ONCE = 100

_artifacts = sa.table(
    "artifacts", *map(sa.column, ("digest", "content", "parts", "world_digest", "stored_at"))
)
_jobs = sa.table("jobs", sa.column("id"), sa.column("world_digest"))


def upgrade() -> None:
    """Make the table, and fill it with what the rows of scenes have."""
    op.create_table(
        "artifacts",
        sa.Column("digest", sa.String(64), primary_key=True),
        sa.Column("content", sa.LargeBinary, nullable=False),
        sa.Column("parts", sa.Text, nullable=False),
        sa.Column("world_digest", sa.String(80), nullable=True),
        sa.Column("stored_at", sa.String(40), nullable=False),
    )
    op.create_index("ix_artifacts_world_digest", "artifacts", ["world_digest"])
    known = _store_documents()
    _name_documents(known)
    if op.get_bind().dialect.name == "sqlite":
        _rebuild_scenes(known)
    else:
        _alter_scenes(known)


def _store_documents() -> dict[int, tuple[str, str]]:
    """Return the content of each row of scenes and the digest of its artifact, by serial."""
    connection = op.get_bind()
    columns = "serial, digest, CAST(document AS TEXT) AS document, CAST(summary AS TEXT) AS summary"
    known: dict[int, tuple[str, str]] = {}
    stored: set[str] = set()
    serials = connection.execute(sa.text("SELECT serial FROM scenes ORDER BY serial")).scalars()
    for serial in serials.all():
        query = sa.text(f"SELECT {columns} FROM scenes WHERE serial = :serial")  # noqa: S608
        row = connection.execute(query, {"serial": serial}).one()
        files = json.loads(row.summary).get("files")
        content = f'{{"files":{json.dumps(files)},\n"document":{_one_line(row.document)}}}'.encode()
        digest = hashlib.sha256(content).hexdigest()
        known[serial] = row.digest, digest
        if digest not in stored:
            stored.add(digest)
            connection.execute(sa.insert(_artifacts).values(_row(content, digest, files, row)))
    return known


def _row(content: bytes, digest: str, files: dict[str, Any] | None, row: Any) -> dict[str, Any]:
    parts = sorted({each for kept in (files or {}).values() for each in kept["sha256"].values()})
    return {
        "digest": digest,
        "content": content,
        "parts": json.dumps(parts),
        "world_digest": row.digest,
        "stored_at": datetime.now(UTC).isoformat(),
    }


def _one_line(document: str) -> str:
    """Return a JSON text without line feeds: parts of an artifact are told apart by them."""
    return document if "\n" not in document else json.dumps(json.loads(document))


def _name_documents(known: dict[int, tuple[str, str]]) -> None:
    """Have jobs name the artifact; where the scene is gone, its content, which is its file's name.

    The server stores those files under that name when it starts: no database can read them.
    """
    connection = op.get_bind()
    artifact_of = dict(known.values())
    for table_name in ("job_bodies", "job_summaries"):
        table = sa.table(table_name, sa.column("job"), sa.column("payload"))
        for job, payload in _payloads(table):
            named = _PATH.sub(
                lambda found: f"{found[1]}{artifact_of.get(found[2], found[2])}{found[3]}", payload
            )
            if named != payload:
                change = sa.update(table).where(table.c.job == job).values(payload=named)
                connection.execute(change)


def _payloads(table: Any) -> Iterator[tuple[str, str]]:
    """Yield the payloads of all jobs, some at a time: each may have megabytes."""
    connection = op.get_bind()
    after = ""
    while True:
        query = sa.select(table.c.job, table.c.payload).where(table.c.job > after)
        rows = connection.execute(query.order_by(table.c.job).limit(_AT_ONCE)).all()
        if not rows:
            return
        for row in rows:
            yield row.job, row.payload
        after = rows[-1].job


def _alter_scenes(known: dict[int, tuple[str, str]]) -> None:
    op.add_column("scenes", sa.Column("artifact", sa.String(64), nullable=True))
    scenes = sa.table("scenes", sa.column("serial"), sa.column("artifact"))
    for serial, (_, digest) in known.items():
        change = sa.update(scenes).where(scenes.c.serial == serial).values(artifact=digest)
        op.get_bind().execute(change)
    op.alter_column("scenes", "artifact", nullable=False)
    op.drop_column("scenes", "document")


def _rebuild_scenes(known: dict[int, tuple[str, str]]) -> None:
    """Make the table anew: SQLite cannot say of a column of a table that it is never null."""
    for name in ("ix_scenes_id", "scenes_by_revision", "scenes_by_key"):
        op.drop_index(name, "scenes")
    op.rename_table("scenes", "former_scenes")
    op.create_table(
        "scenes",
        sa.Column("serial", sa.Integer, primary_key=True),
        sa.Column("id", sa.String(64), nullable=False),
        sa.Column("revision", sa.Integer, nullable=False),
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("artifact", sa.String(64), nullable=False),
        sa.Column("name", sa.String(256), nullable=False),
        sa.Column("created_at", sa.String(40), nullable=False),
        sa.Column("summary", sa.JSON, nullable=False),
        sa.Column("key", sa.String(200), nullable=True),
        sa.Column("request_digest", sa.String(64), nullable=True),
        sa.UniqueConstraint("id", "revision"),
    )
    move = "INSERT INTO scenes SELECT serial, id, revision, digest, :artifact, name, created_at, "
    move += 'summary, "key", request_digest FROM former_scenes WHERE serial = :serial'
    for serial, (_, digest) in known.items():
        op.get_bind().execute(sa.text(move), {"artifact": digest, "serial": serial})
    op.drop_table("former_scenes")
    op.create_index("ix_scenes_id", "scenes", ["id"])
    op.create_index("scenes_by_revision", "scenes", ["revision", "serial"])
    op.create_index("scenes_by_key", "scenes", ["key"], unique=True)
