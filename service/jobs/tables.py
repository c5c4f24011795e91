"""The tables of jobs and their events, and a job as a value."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    Float,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    UniqueConstraint,
    text,
)

from service.jobs.json_column import JsonText
from service.jobs.json_text import Encoded
from service.jobs.states import JobState

FINISHED = "finished"

metadata = MetaData()

# Columns that are not called as the fields of a job are.
COLUMNS = {
    "sequence": "serial",
    "queue": "lane",
    "world_digest": "warm_key",
    "time_limit": "allowed",
}

# Motions of one scene are not proven against each other: one job at a time, whatever the server.
_OPEN_EXECUTION = text("lane = 'execution' AND state IN ('queued', 'running')")

# `serial` orders pages; SQLite counts by itself only in INTEGER primary keys.
jobs = Table(
    "jobs",
    metadata,
    Column("serial", BigInteger().with_variant(Integer, "sqlite"), primary_key=True),
    Column("id", String(64), nullable=False, unique=True),
    Column("lane", String(20), nullable=False),
    Column("task", String(200), nullable=False),
    Column("scene", String(64), nullable=True),
    Column("warm_key", String(80), nullable=True),
    Column("priority", Integer, nullable=False),
    Column("allowed", Float, nullable=True),
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
    UniqueConstraint("lane", "key"),
    Index("jobs_by_state", "lane", "state", "serial"),
    # One for each way in which lists are asked for: a page reads its own rows and no others.
    Index("jobs_of_lane", "lane", "serial"),
    Index("jobs_of_scene", "lane", "scene", "serial"),
    Index("jobs_of_scene_by_state", "lane", "scene", "state", "serial"),
    Index("jobs_of_content", "lane", "warm_key", "serial"),
    Index(
        "one_open_execution_of_scene",
        "scene",
        unique=True,
        sqlite_where=_OPEN_EXECUTION,
        postgresql_where=_OPEN_EXECUTION,
    ),
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
    "job_briefs",
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


@dataclass(frozen=True)
class JobSpec:
    """What a job shall do.

    Attributes:
        queue: Which slots may run it.
        task: Importable function, `module:function`, called with the payload and a channel.
        payload: JSON-compatible; `cancel_grace` in it stands for the lane's [s].
        prefix: Of the job's id.
        scene: Id of the scene it is about, for listing.
        world_digest: Workers that ran this key lately are preferred.
        priority: Larger comes first.
        time_limit: Seconds after which it is told to end, and soon after made to; None for ever.
        max_attempts: How often it may be run if its process dies.
        key: Idempotency key within the lane, or None.
        request_digest: What a second request with the same key must match.
        follows: Sequence of the newest job of its queue in its scene, 0 for none, as the request
            knows it: the job is refused if there is another one by now. None if that is no matter.
    """

    queue: str
    task: str
    payload: dict[str, Any]
    prefix: str = "job"
    scene: str | None = None
    world_digest: str | None = None
    priority: int = 0
    time_limit: float | None = None
    max_attempts: int = 2
    key: str | None = None
    request_digest: str = ""
    follows: int | None = None


@dataclass(frozen=True)
class JobSummary:
    """A job as lists have it: its payload, result and failure lack what is large."""

    id: str
    sequence: int
    queue: str
    task: str
    payload: dict[str, Any]
    scene: str | None
    world_digest: str | None
    priority: int
    time_limit: float | None
    max_attempts: int
    attempts: int
    key: str | None
    request_digest: str
    state: JobState
    stage: str
    progress: float
    is_cancel_requested: bool
    num_events: int
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None
    result: dict[str, Any] | None
    failure: dict[str, Any] | None
    made_by: dict[str, str] | None


@dataclass(frozen=True)
class Job(JobSummary):
    """A job as the tables have it, whole."""


@dataclass(frozen=True)
class JobText:
    """A job whose result is passed on as it is: it may be megabytes, and is not read here.

    Attributes:
        summary: As lists have it.
        result: Whole, None where there is none.
    """

    summary: JobSummary
    result: Encoded | None


@dataclass(frozen=True)
class LoggedEvent:
    """An event of a job; numbers count from 1 without gaps."""

    job: str
    number: int
    type: str
    data: dict[str, Any]
    at: str

    @property
    def is_last(self) -> bool:
        """Whether nothing happens to the job after it."""
        return self.type == FINISHED


@dataclass(frozen=True)
class JobPage:
    """Some jobs of a lane, newest first, and the number before which the next page begins."""

    jobs: list[JobSummary]
    following: int | None
