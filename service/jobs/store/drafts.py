"""Drafts: jobs that are not in the tables yet, and how they enter."""

import json
import secrets
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from sqlalchemy import Connection, insert
from sqlalchemy.dialects import postgresql

from service.jobs.errors import Overtaken
from service.jobs.job import Job, JobSpec
from service.jobs.json_text import Encoded, encode
from service.jobs.outline import without
from service.jobs.states import JobState
from service.jobs.store.entries import Entry, enter, write_robots
from service.jobs.store.event_log import append_events
from service.jobs.store.queries import find_by_idempotency_key, job_of, now
from service.jobs.store.sql.notifications import note_change
from service.jobs.store.sql.prepared import Prepared
from service.jobs.store.sql.tables import bodies, jobs, summaries
from service.jobs.task import outline_of

# Fields of a spec that are columns.
_NO_COLUMNS = {"payload", "prefix", "follows", "robots", "waits"}
_COPIED = [field.name for field in fields(JobSpec) if field.name not in _NO_COLUMNS]
_NOT_YET = (
    "started_at",
    "finished_at",
    "cancel_requested_at",
    "result",
    "failure",
    "made_by",
)
_COUNTED = ("sequence", *_NOT_YET)
# Nothing is inserted where an index says that there is such a job; SQLite says it alike.
_ADD_JOB = Prepared(
    postgresql.insert(jobs).on_conflict_do_nothing().returning(jobs.c.sequence),
    *(column.name for column in jobs.c if column.name not in _COUNTED),
)
_ADD_BODY = Prepared(insert(bodies), "job", "payload")
_ADD_SUMMARY = Prepared(insert(summaries), "job", "payload")


@dataclass(frozen=True)
class Draft:
    """A job that is not in the tables yet.

    Attributes:
        job: As it will be read, but for its sequence, which is 0.
        row: Its columns.
        payload: As JSON.
        entry: How it enters its scene, if it moves robots.
    """

    job: Job
    row: Mapping[str, Any]
    payload: str
    entry: Entry | None


def draft(spec: JobSpec) -> Draft:
    """Return a new queued job with an identifier of its own.

    Raises:
        TypeError: The payload is not JSON-compatible.
    """
    given = spec.payload
    row, payload = _queued_row(spec), given.text if isinstance(given, Encoded) else encode(given)
    later = dict.fromkeys(_NOT_YET)
    job = job_of({**row, "sequence": 0, "payload": json.loads(payload), **later})
    entry = Entry(spec.robots, spec.follows, spec.waits) if spec.robots else None
    return Draft(job, row, payload, entry)


def insert_job(connection: Connection, drafted: Draft) -> Job | None:
    """Write a job as it was drafted, and return it as it would be read; None if there is one.

    There is one if another server has used its key in the meantime.

    Raises:
        Overtaken: Another job has entered its scene, or moves one of its robots.
    """
    job, payload = drafted.job, drafted.payload
    short = without(job.payload, outline_of(job.task).payload)
    summary = payload if short is job.payload else encode(short)
    entry = drafted.entry
    if entry is not None and not enter(connection, job.queue, job.scene or "", entry):
        if find_by_idempotency_key(connection, job) is None:
            raise Overtaken
        return None
    sequence = _ADD_JOB(connection, **drafted.row).scalar()
    if sequence is None:
        return None
    if entry is not None:
        write_robots(connection, job.id, entry)
        note_change(connection, job.scene or "")
    _ADD_BODY(connection, job=job.id, payload=payload)
    _ADD_SUMMARY(connection, job=job.id, payload=summary)
    append_events(connection, job.id, 1, [("queued", Encoded("{}"))])
    return replace(job, sequence=sequence)


def _queued_row(spec: JobSpec) -> dict[str, Any]:
    """Return the columns of a new job, with an identifier of its own."""
    return {
        **{name: getattr(spec, name) for name in _COPIED},
        "id": f"{spec.prefix}_{secrets.token_hex(10)}",
        "attempts": 0,
        "state": JobState.QUEUED.value,
        "stage": "",
        "progress": 0.0,
        "is_cancel_requested": False,
        "num_events": 1,
        "created_at": now(),
    }
