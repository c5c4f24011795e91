"""The tables of jobs, of their events, and of artifacts."""

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    Float,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    UniqueConstraint,
)

from service.jobs.store.sql.json_column import JsonText

metadata = MetaData()

# `sequence` orders pages; SQLite counts by itself only in INTEGER primary keys.
jobs = Table(
    "jobs",
    metadata,
    Column("sequence", BigInteger().with_variant(Integer, "sqlite"), primary_key=True),
    Column("id", String(64), nullable=False, unique=True),
    Column("queue", String(20), nullable=False),
    Column("task", String(200), nullable=False),
    Column("scene", String(64), nullable=True),
    Column("world_digest", String(80), nullable=True),
    Column("priority", Integer, nullable=False),
    Column("time_limit", Float, nullable=True),
    Column("max_attempts", Integer, nullable=False),
    Column("attempts", Integer, nullable=False),
    Column("key", String(200), nullable=True),
    Column("request_digest", String(64), nullable=False),
    Column("state", String(12), nullable=False),
    Column("stage", String(40), nullable=False),
    Column("progress", Float, nullable=False),
    Column("is_cancel_requested", Boolean, nullable=False),
    Column("num_events", Integer, nullable=False),
    Column("created_at", String(40), nullable=False),
    Column("started_at", String(40), nullable=True),
    Column("finished_at", String(40), nullable=True),
    Column("cancel_requested_at", String(40), nullable=True),
    Column("batch", String(64), nullable=True),
    Column("client", String(80), nullable=False, server_default=""),
    UniqueConstraint("queue", "key"),
    Index("jobs_by_state", "queue", "state", "sequence"),
    # One for each filter of lists: a page reads its own rows and no others.
    Index("jobs_of_queue", "queue", "sequence"),
    Index("jobs_of_scene", "queue", "scene", "sequence"),
    Index("jobs_of_scene_by_state", "queue", "scene", "state", "sequence"),
    Index("jobs_of_batch", "batch", "sequence"),
    Index("jobs_of_content", "queue", "world_digest", "sequence"),
)

# Which robots a job moves; see `entries`.
job_robots = Table(
    "job_robots",
    metadata,
    Column("job", String(64), primary_key=True),
    Column("robot", String(256), primary_key=True),
    Column("is_waiting", Boolean, nullable=False),
    Index("robots_waited_for", "is_waiting", "job"),
)

# How many jobs that move robots have entered each scene.
scene_entries = Table(
    "scene_entries",
    metadata,
    Column("scene", String(64), primary_key=True),
    Column("number", BigInteger, nullable=False),
)

# What is large is apart from what changes often: databases write rows whole.
bodies = Table(
    "job_bodies",
    metadata,
    Column("job", String(64), primary_key=True),
    Column("payload", JsonText, nullable=False),
    Column("result", JsonText, nullable=True),
    Column("failure", JsonText, nullable=True),
)

# What lists show of bodies, for they read many: see `outline`.
summaries = Table(
    "job_summaries",
    metadata,
    Column("job", String(64), primary_key=True),
    Column("payload", JsonText, nullable=False),
    Column("result", JsonText, nullable=True),
    Column("failure", JsonText, nullable=True),
)

events = Table(
    "job_events",
    metadata,
    Column("job", String(64), primary_key=True),
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("type", String(64), nullable=False),
    Column("data", JsonText, nullable=False),
    Column("at", String(40), nullable=False),
)


# Versions of what ran a job last, by name.
makers = Table(
    "job_makers",
    metadata,
    Column("job", String(64), primary_key=True),
    Column("made_by", JsonText, nullable=False),
)

# One row: how many servers have owned this database, and whether the last one gave it back.
owner = Table(
    "job_owner",
    metadata,
    Column("id", Integer, primary_key=True, autoincrement=False),
    Column("epoch", BigInteger, nullable=False),
    Column("is_released", Boolean, nullable=False),
)

# Bytes by their sha256. One without a `world_digest` is a part of others, and stays with them.
artifacts = Table(
    "artifacts",
    metadata,
    Column("digest", String(64), primary_key=True),
    Column("content", LargeBinary, nullable=False),
    Column("parts", JsonText, nullable=False),
    Column("world_digest", String(80), nullable=True, index=True),
    Column("stored_at", String(40), nullable=False),
)
