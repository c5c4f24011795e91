"""How a job enters the tables, and how an idempotency key finds the one that is there already."""

import json
import secrets
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from sqlalchemy import Connection, bindparam, insert, select
from sqlalchemy.dialects import postgresql

from service.jobs.errors import IdempotencyConflict, Overtaken
from service.jobs.json_text import Encoded, encode
from service.jobs.outline import without
from service.jobs.prepared import Prepared
from service.jobs.reading import job_of, jobs_where, now
from service.jobs.states import JobState
from service.jobs.tables import COLUMNS, Job, JobSpec, bodies, jobs, summaries
from service.jobs.tasks import outline_of
from service.jobs.transitions import append_events

_COPIED = (
    "queue",
    "task",
    "scene",
    "world_digest",
    "priority",
    "time_limit",
    "max_attempts",
    "key",
    "request_digest",
)
_NOT_YET = ("started_at", "finished_at", "result", "failure", "made_by")
_COUNTED = ("serial", *_NOT_YET)
# Nothing is inserted where an index says that there is such a job; SQLite says it alike.
_ADD_JOB = Prepared(
    postgresql.insert(jobs).on_conflict_do_nothing().returning(jobs.c.serial),
    *(column.name for column in jobs.c if column.name not in _COUNTED),
)
_NEWEST_OTHER = Prepared(
    select(jobs.c.serial)
    .where(
        jobs.c.lane == bindparam("in_queue"),
        jobs.c.scene == bindparam("in_scene"),
        jobs.c.serial != bindparam("own"),
    )
    .order_by(jobs.c.serial.desc())
    .limit(1)
)
_ADD_BODY = Prepared(insert(bodies), "job", "payload")
_ADD_BRIEF = Prepared(insert(summaries), "job", "payload")


@dataclass(frozen=True)
class Draft:
    """A job that is not in the tables yet.

    Attributes:
        job: As it will be read, but for its serial, which is 0.
        row: Its columns.
        payload: As JSON.
        follows: As the spec has it.
    """

    job: Job
    row: Mapping[str, Any]
    payload: str
    follows: int | None


def draft(spec: JobSpec) -> Draft:
    """Return a new queued job with an identifier of its own.

    Raises:
        TypeError: The payload is not JSON-compatible.
    """
    row, payload = _queued_row(spec), encode(spec.payload)
    later = dict.fromkeys(_NOT_YET)
    job = job_of({**row, "serial": 0, "payload": json.loads(payload), **later})
    return Draft(job, row, payload, spec.follows)


def insert_job(connection: Connection, drafted: Draft) -> Job | None:
    """Write a job as it was drafted, and return it as it would be read; None if there is one.

    There is one if another server has used its key in the meantime.

    Raises:
        Overtaken: Another job of its queue has entered its scene.
    """
    job, payload = drafted.job, drafted.payload
    short = without(job.payload, outline_of(job.task).payload)
    brief = payload if short is job.payload else encode(short)
    serial = _ADD_JOB(connection, **drafted.row).scalar_one_or_none()
    if serial is None:
        if find_by_idempotency_key(connection, job) is None:
            raise Overtaken
        return None
    if drafted.follows is not None:
        # Only now: what has entered the scene before this job is visible, and nothing enters after.
        newest = _NEWEST_OTHER(connection, in_queue=job.queue, in_scene=job.scene, own=serial)
        if (newest.scalar_one_or_none() or 0) != drafted.follows:
            raise Overtaken
    _ADD_BODY(connection, job=job.id, payload=payload)
    _ADD_BRIEF(connection, job=job.id, payload=brief)
    append_events(connection, job.id, 1, [("queued", Encoded("{}"))])
    return replace(job, sequence=serial)


def _queued_row(spec: JobSpec) -> dict[str, Any]:
    """Return the columns of a new job, with an identifier of its own."""
    return {
        **{COLUMNS.get(name, name): getattr(spec, name) for name in _COPIED},
        "id": f"{spec.prefix}_{secrets.token_hex(10)}",
        "attempts": 0,
        "state": JobState.QUEUED.value,
        "stage": "",
        "progress": 0.0,
        "is_cancel_requested": False,
        "num_events": 1,
        "created_at": now(),
    }


def find_by_idempotency_key(connection: Connection, spec: JobSpec | Job) -> Job | None:
    """Return the job that an idempotency key names, if there is one.

    Raises:
        IdempotencyConflict: The key was used for another request.
    """
    if spec.key is None:
        return None
    named = (jobs.c.lane == spec.queue) & (jobs.c.key == spec.key)
    found = jobs_where(connection, named)
    if found and found[0].request_digest != spec.request_digest:
        known = found[0].id
        message = f"the idempotency key {spec.key!r} was used for another request: {known}"
        raise IdempotencyConflict(message, {"key": spec.key, "job": known})
    return found[0] if found else None
