"""How a job enters the tables, and how an idempotency key finds the one that is there already."""

import secrets
from typing import Any

from sqlalchemy import Connection

from service.jobs.errors import IdempotencyConflict
from service.jobs.reading import jobs_where, now
from service.jobs.records import Job, JobSpec, jobs
from service.jobs.states import JobState

_COPIED = (
    "lane",
    "task",
    "scene",
    "warm_key",
    "priority",
    "allowed",
    "max_attempts",
    "key",
    "request_digest",
)


def queued_row(spec: JobSpec) -> dict[str, Any]:
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


def job_by_key(connection: Connection, spec: JobSpec) -> Job | None:
    """Return the job that an idempotency key names, if there is one.

    Raises:
        IdempotencyConflict: The key was used for another request.
    """
    if spec.key is None:
        return None
    named = (jobs.c.lane == spec.lane) & (jobs.c.key == spec.key)
    found = jobs_where(connection, named)
    if found and found[0].request_digest != spec.request_digest:
        known = found[0].id
        message = f"the idempotency key {spec.key!r} was used for another request: {known}"
        raise IdempotencyConflict(message, {"key": spec.key, "job": known})
    return found[0] if found else None
