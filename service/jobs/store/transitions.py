"""How a job enters the tables, and changes its state: each with the event that tells of it."""

import json
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import Any

from sqlalchemy import Connection, Update, bindparam, insert, or_, select, update
from sqlalchemy.dialects import postgresql

from service.jobs.errors import Overtaken
from service.jobs.job import FINISHED, Job, JobSpec, JobText, LoggedEvent, PendingEvent
from service.jobs.json_text import Encoded, encode
from service.jobs.outline import without
from service.jobs.states import JobEvent, JobState, advance, sources
from service.jobs.store.database import Prepared
from service.jobs.store.queries import (
    columns_of,
    decoded,
    find_by_idempotency_key,
    job_of,
    now,
    summary_of,
)
from service.jobs.store.tables import bodies, events, jobs, summaries
from service.jobs.task import outline_of

_MAX_STAGE = 40
_EVENT_NAMES = {
    JobEvent.START: "started",
    JobEvent.REQUEUE: "requeued",
    JobEvent.SUCCEED: FINISHED,
    JobEvent.FAIL: FINISHED,
    JobEvent.CANCEL: FINISHED,
}
# Fields of a spec that are columns.
_NO_COLUMNS = {"payload", "prefix", "follows"}
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
_NEWEST_OTHER = Prepared(
    select(jobs.c.sequence)
    .where(
        jobs.c.queue == bindparam("in_queue"),
        jobs.c.scene == bindparam("in_scene"),
        jobs.c.sequence != bindparam("own"),
    )
    .order_by(jobs.c.sequence.desc())
    .limit(1)
)
_ADD_BODY = Prepared(insert(bodies), "job", "payload")
_ADD_SUMMARY = Prepared(insert(summaries), "job", "payload")
_ADD_EVENT = Prepared(insert(events), "job", "number", "type", "data", "at")


@dataclass(frozen=True)
class Draft:
    """A job that is not in the tables yet.

    Attributes:
        job: As it will be read, but for its sequence, which is 0.
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
    job = job_of({**row, "sequence": 0, "payload": json.loads(payload), **later})
    return Draft(job, row, payload, spec.follows)


def insert_job(connection: Connection, drafted: Draft) -> Job | None:
    """Write a job as it was drafted, and return it as it would be read; None if there is one.

    There is one if another server has used its key in the meantime.

    Raises:
        Overtaken: Another job of its queue has entered its scene.
    """
    job, payload = drafted.job, drafted.payload
    short = without(job.payload, outline_of(job.task).payload)
    summary = payload if short is job.payload else encode(short)
    sequence = _ADD_JOB(connection, **drafted.row).scalar_one_or_none()
    if sequence is None:
        if find_by_idempotency_key(connection, job) is None:
            raise Overtaken
        return None
    if drafted.follows is not None:
        # Only now: what has entered the scene before this job is visible, and nothing enters after.
        newest = _NEWEST_OTHER(connection, in_queue=job.queue, in_scene=job.scene, own=sequence)
        if (newest.scalar_one_or_none() or 0) != drafted.follows:
            raise Overtaken
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


@dataclass(frozen=True)
class Transition:
    """A change of a job's state, as it was written.

    Attributes:
        event: That tells of it.
        attempts: How often the job was started by now.
        is_cancel_requested: Whether its end was requested.
        columns: Of the job in its table, as they are now.
    """

    event: LoggedEvent
    attempts: int
    is_cancel_requested: bool
    columns: Mapping[str, Any]


def apply_event(
    connection: Connection,
    identifier: str,
    event: JobEvent,
    changes: Mapping[str, Any],
    data: Mapping[str, Any],
    only: JobState | None = None,
) -> Transition | None:
    """Apply an event if the job's state allows it, and log it; None if the job has moved on.

    Args:
        connection: In a transaction.
        identifier: Of the job.
        event: The event.
        changes: More columns that change; `more_attempts` are added to those that there were.
        data: Of the logged event.
        only: The state that the job must be in, if not any that allows the event.
    """
    after = advance(_before(event, only)[0], event)
    given = {f"new_{name}": content for name, content in changes.items()}
    if after.is_final:
        given["new_finished_at"] = now()
        data = {"state": after.value, **data}
    statement = _transition(event, only, tuple(given))
    row = statement(connection, job_id=identifier, **given).first()
    if row is None:
        return None
    name = _EVENT_NAMES[event]
    [logged] = append_events(connection, identifier, row.num_events, [(name, dict(data))])
    # A prepared statement has booleans as the database has them.
    columns = {**columns_of(row), "is_cancel_requested": bool(row.is_cancel_requested)}
    return Transition(logged, row.attempts, columns["is_cancel_requested"], columns)


def ended_job(
    transition: Transition,
    payload: Mapping[str, Any],
    made_by: Mapping[str, str],
    result: Encoded | None,
    summary: Any,
) -> JobText:
    """Return a job that has just ended as it would be read.

    Args:
        transition: Its last move.
        payload: Its own.
        made_by: The versions of what ran it.
        result: Whole, None if it has none.
        summary: What lists show of the result.
    """
    failure = json.loads(encode(transition.event.data.get("failure")))
    content = {"payload": payload, "result": summary, "failure": failure, "made_by": made_by}
    return JobText(summary_of({**transition.columns, **content}), result)


def reserve_events(
    connection: Connection,
    identifier: str,
    new_events: Sequence[PendingEvent],
    *,
    may_wait: bool,
) -> int | None:
    """Return the first number for events of a job, None if it has ended; its stage is theirs.

    Args:
        connection: In a transaction.
        identifier: Of the job.
        new_events: Types and data.
        may_wait: Whether the job may also be queued.
    """
    changes: dict[str, Any] = {}
    for _, data in new_events:
        changes |= _progress_in(decoded(data))
    given = {f"new_{name}": content for name, content in changes.items()}
    statement = _reservation(tuple(given), may_wait=may_wait)
    row = statement(connection, job_id=identifier, more=len(new_events), **given).first()
    return None if row is None else row.num_events - len(new_events) + 1


def append_events(
    connection: Connection,
    identifier: str,
    first: int,
    new_events: Sequence[tuple[str, Encoded | dict[str, Any]]],
) -> list[LoggedEvent]:
    """Append events whose numbers have been reserved by adding to `num_events`.

    Args:
        connection: In the transaction that reserved them.
        identifier: Of the job.
        first: The first number.
        new_events: Types and data.
    """
    at = now()
    texts = [data.text if isinstance(data, Encoded) else encode(data) for _, data in new_events]
    rows = [
        {"job": identifier, "number": first + i, "type": type_, "data": text, "at": at}
        for i, ((type_, _), text) in enumerate(zip(new_events, texts, strict=True))
    ]
    _ADD_EVENT.many(connection, rows)
    return [
        LoggedEvent(identifier, first + i, type_, decoded(data), at)
        for i, (type_, data) in enumerate(new_events)
    ]


def _before(event: JobEvent, only: JobState | None) -> tuple[JobState, ...]:
    return sources(event) if only is None else (only,)


@cache
def _transition(event: JobEvent, only: JobState | None, given: tuple[str, ...]) -> Prepared:
    before = _before(event, only)
    columns: dict[str, Any] = {name.removeprefix("new_"): bindparam(name) for name in given}
    more_attempts = columns.pop("more_attempts", None)
    if more_attempts is not None:
        columns["attempts"] = jobs.c.attempts + more_attempts
    columns |= {"state": advance(before[0], event).value, "num_events": jobs.c.num_events + 1}
    return Prepared(_update_in(before).values(columns).returning(*jobs.c))


@cache
def _reservation(given: tuple[str, ...], *, may_wait: bool) -> Prepared:
    states = [state for state in JobState if not state.is_final] if may_wait else [JobState.RUNNING]
    columns: dict[str, Any] = {name.removeprefix("new_"): bindparam(name) for name in given}
    columns["num_events"] = jobs.c.num_events + bindparam("more")
    return Prepared(_update_in(states).values(columns).returning(jobs.c.num_events))


def _update_in(states: Sequence[JobState]) -> Update:
    is_in = or_(*(jobs.c.state == state.value for state in states))
    return update(jobs).where(jobs.c.id == bindparam("job_id"), is_in)


def _progress_in(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the columns of a job that an event changes: `stage` and `progress` in its data."""
    changes: dict[str, Any] = {}
    stage, progress = data.get("stage"), data.get("progress")
    if isinstance(stage, str):
        changes["stage"] = stage[:_MAX_STAGE]
    if isinstance(progress, int | float):
        changes["progress"] = min(1.0, max(0.0, float(progress)))
    return changes
