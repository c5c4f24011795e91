"""The tables of version 0.1: made where they are missing, recognized where they are there.

Version 0.1 and what came before it stored no revision.
"""

import sqlalchemy as sa
from alembic import op

from service.jobs.errors import DatabaseUnrecognized

revision = "0001"
down_revision = None

_SERIAL = sa.BigInteger().with_variant(sa.Integer, "sqlite")
metadata = sa.MetaData()

sa.Table(
    "jobs",
    metadata,
    sa.Column("serial", _SERIAL, primary_key=True),
    sa.Column("id", sa.String(64), nullable=False, unique=True),
    sa.Column("lane", sa.String(20), nullable=False),
    sa.Column("task", sa.String(200), nullable=False),
    sa.Column("scene", sa.String(64), nullable=True),
    sa.Column("warm_key", sa.String(80), nullable=True),
    sa.Column("priority", sa.Integer, nullable=False),
    sa.Column("allowed", sa.Float, nullable=True),
    sa.Column("max_attempts", sa.Integer, nullable=False),
    sa.Column("attempts", sa.Integer, nullable=False),
    sa.Column("key", sa.String(200), nullable=True),
    sa.Column("request_digest", sa.String(64), nullable=False),
    sa.Column("state", sa.String(12), nullable=False),
    sa.Column("stage", sa.String(40), nullable=False),
    sa.Column("progress", sa.Float, nullable=False),
    sa.Column("is_cancel_requested", sa.Boolean, nullable=False),
    sa.Column("num_events", sa.Integer, nullable=False),
    sa.Column("created_at", sa.String(40), nullable=False),
    sa.Column("started_at", sa.String(40), nullable=True),
    sa.Column("finished_at", sa.String(40), nullable=True),
    sa.UniqueConstraint("lane", "key"),
    sa.Index("jobs_by_state", "lane", "state", "serial"),
    sa.Index("jobs_of_lane", "lane", "serial"),
    sa.Index("jobs_of_scene", "lane", "scene", "serial"),
    sa.Index("jobs_of_scene_by_state", "lane", "scene", "state", "serial"),
    sa.Index("jobs_of_content", "lane", "warm_key", "serial"),
)
for _name in ("job_bodies", "job_briefs"):
    sa.Table(
        _name,
        metadata,
        sa.Column("job", sa.String(64), primary_key=True),
        sa.Column("payload", sa.Text, nullable=False),
        sa.Column("result", sa.Text, nullable=True),
        sa.Column("failure", sa.Text, nullable=True),
    )
sa.Table(
    "job_events",
    metadata,
    sa.Column("job", sa.String(64), primary_key=True),
    sa.Column("number", sa.Integer, primary_key=True, autoincrement=False),
    sa.Column("type", sa.String(64), nullable=False),
    sa.Column("data", sa.Text, nullable=False),
    sa.Column("at", sa.String(40), nullable=False),
)
sa.Table(
    "job_makers",
    metadata,
    sa.Column("job", sa.String(64), primary_key=True),
    sa.Column("made_by", sa.Text, nullable=False),
)
sa.Table(
    "job_owner",
    metadata,
    sa.Column("id", sa.Integer, primary_key=True, autoincrement=False),
    sa.Column("epoch", sa.BigInteger, nullable=False),
    sa.Column("is_released", sa.Boolean, nullable=False),
)
sa.Table(
    "scenes",
    metadata,
    sa.Column("serial", _SERIAL, primary_key=True),
    sa.Column("id", sa.String(64), nullable=False, index=True),
    sa.Column("revision", sa.Integer, nullable=False),
    sa.Column("digest", sa.String(64), nullable=False),
    sa.Column("name", sa.String(256), nullable=False),
    sa.Column("created_at", sa.String(40), nullable=False),
    sa.Column("document", sa.JSON, nullable=False),
    sa.Column("summary", sa.JSON, nullable=False),
    sa.UniqueConstraint("id", "revision"),
    sa.Index("scenes_by_revision", "revision", "serial"),
)


def upgrade() -> None:
    """Make what is missing.

    Raises:
        DatabaseUnrecognized: A table has one of these names, and lacks columns.
    """
    connection = op.get_bind()
    inspector = sa.inspect(connection)
    known = set(inspector.get_table_names())
    for table in metadata.sorted_tables:
        if table.name not in known:
            table.create(connection)
            continue
        missing = {c.name for c in table.c} - {c["name"] for c in inspector.get_columns(table.name)}
        if missing:
            raise DatabaseUnrecognized.of(table.name, sorted(missing))
        for index in table.indexes:
            index.create(connection, checkfirst=True)
