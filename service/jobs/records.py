"""The tables of jobs and their events, and a job as a value."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import (
    JSON,
    Boolean,
    Column,
    Float,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    UniqueConstraint,
)

from service.jobs.states import JobState

metadata = MetaData()

jobs = Table(
    "jobs",
    metadata,
    Column("serial", Integer, primary_key=True, autoincrement=True),
    Column("id", String(40), nullable=False, unique=True),
    Column("lane", String(20), nullable=False),
    Column("task", String(200), nullable=False),
    Column("payload", JSON, nullable=False),
    Column("scene", String(40), nullable=True),
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
    Column("created_at", String(40), nullable=False),
    Column("started_at", String(40), nullable=True),
    Column("finished_at", String(40), nullable=True),
    Column("result", JSON, nullable=True),
    Column("failure", JSON, nullable=True),
    UniqueConstraint("lane", "key"),
    Index("jobs_by_state", "lane", "state", "serial"),
)

events = Table(
    "job_events",
    metadata,
    Column("job", String(40), primary_key=True),
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("type", String(40), nullable=False),
    Column("data", JSON, nullable=False),
    Column("at", String(40), nullable=False),
)


@dataclass(frozen=True)
class JobSpec:
    """What a job shall do.

    Attributes:
        lane: Which slots may run it.
        task: Importable function, `module:function`, called with the payload and a channel.
        payload: JSON-compatible.
        prefix: Of the job's id.
        scene: Id of the scene it is about, for listing.
        warm_key: Slots that ran this key last are preferred.
        priority: Larger comes first.
        allowed: Seconds after which its process is ended, or None.
        max_attempts: How often it may be run if its process dies.
        key: Idempotency key within the lane, or None.
        request_digest: What a second request with the same key must match.
    """

    lane: str
    task: str
    payload: dict[str, Any]
    prefix: str = "job"
    scene: str | None = None
    warm_key: str | None = None
    priority: int = 0
    allowed: float | None = None
    max_attempts: int = 2
    key: str | None = None
    request_digest: str = ""


@dataclass(frozen=True)
class Job:
    """A job as the table has it."""

    id: str
    serial: int
    lane: str
    task: str
    payload: dict[str, Any]
    scene: str | None
    warm_key: str | None
    priority: int
    allowed: float | None
    max_attempts: int
    attempts: int
    key: str | None
    request_digest: str
    state: JobState
    stage: str
    progress: float
    is_cancel_requested: bool
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None
    result: dict[str, Any] | None
    failure: dict[str, Any] | None


@dataclass(frozen=True)
class LoggedEvent:
    """An event of a job; numbers count from 1 without gaps."""

    job: str
    number: int
    type: str
    data: dict[str, Any]
    at: str
