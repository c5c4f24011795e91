"""What is asked of the tables of jobs, and rows as values."""

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    Row,
    Select,
    Table,
    Text,
    bindparam,
    func,
    select,
    type_coerce,
)

from service.jobs.errors import UnknownJob
from service.jobs.json_text import Encoded
from service.jobs.states import JobState
from service.jobs.tables import (
    COLUMNS,
    Job,
    JobSummary,
    JobText,
    LoggedEvent,
    bodies,
    events,
    jobs,
    makers,
    summaries,
)

_MAX_STAGE = 40
_FIELDS = {column: field for field, column in COLUMNS.items()}


def _jobs_with(content: Table) -> Select[Any]:
    columns = (content.c.payload, content.c.result, content.c.failure, makers.c.made_by)
    joined = select(jobs, *columns).join(content, content.c.job == jobs.c.id)
    return joined.join(makers, makers.c.job == jobs.c.id, isouter=True)


_WHOLE, _BRIEF = _jobs_with(bodies), _jobs_with(summaries)
# What is asked again and again is built once: that takes longer than to ask it.
_OF_ID = jobs.c.id == bindparam("job_id")
_ONE_WHOLE, _ONE_BRIEF = _WHOLE.where(_OF_ID), _BRIEF.where(_OF_ID)
_ONE_TEXT = _ONE_BRIEF.add_columns(type_coerce(bodies.c.result, Text).label("text")).join(
    bodies, bodies.c.job == jobs.c.id
)
_OF_JOB = select(events).where(events.c.job == bindparam("job_id"))
_AFTER = _OF_JOB.where(events.c.number > bindparam("after")).order_by(events.c.number)
_OF_TYPE = _OF_JOB.where(events.c.type == bindparam("of_type"))
_NEWEST = _OF_TYPE.order_by(events.c.number.desc()).limit(1)


def now() -> str:
    """Return the time as it is recorded (ISO 8601, UTC)."""
    return datetime.now(UTC).isoformat()


def decoded(data: Encoded | dict[str, Any]) -> dict[str, Any]:
    """Return content that may be text already."""
    return json.loads(data.text) if isinstance(data, Encoded) else data


def progress_in(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the columns of a job that an event changes: `stage` and `progress` in its data."""
    changes: dict[str, Any] = {}
    stage, progress = data.get("stage"), data.get("progress")
    if isinstance(stage, str):
        changes["stage"] = stage[:_MAX_STAGE]
    if isinstance(progress, int | float):
        changes["progress"] = min(1.0, max(0.0, float(progress)))
    return changes


def jobs_where(connection: Connection, condition: ColumnElement[bool]) -> list[Job]:
    """Return all jobs for which a condition holds, oldest first."""
    rows = connection.execute(_WHOLE.where(condition).order_by(jobs.c.serial))
    return [job_of(columns_of(row)) for row in rows]


def job(connection: Connection, identifier: str) -> Job:
    """Return a job.

    Raises:
        UnknownJob: There is none.
    """
    return job_of(_one(connection, _ONE_WHOLE, identifier))


def brief(connection: Connection, identifier: str) -> JobSummary:
    """Return a job as lists have it; raises as `job`."""
    return brief_of(_one(connection, _ONE_BRIEF, identifier))


def job_text(connection: Connection, identifier: str) -> JobText:
    """Return a job as lists have it, and its whole result as text; raises as `job`."""
    columns = _one(connection, _ONE_TEXT, identifier)
    text = columns.pop("text")
    return JobText(brief_of(columns), None if text is None else Encoded(text))


def unfinished(connection: Connection) -> list[Job]:
    """Return every job that is queued or running, oldest first."""
    states = [state.value for state in JobState if not state.is_final]
    return jobs_where(connection, jobs.c.state.in_(states))


def page(
    connection: Connection, wanted: Mapping[str, str | None], before: int | None, limit: int
) -> list[JobSummary]:
    """Return jobs whose columns are as wanted, newest first, with a serial below `before`."""
    query = _BRIEF
    for name, content in wanted.items():
        query = (
            query if content is None else query.where(jobs.c[COLUMNS.get(name, name)] == content)
        )
    query = query if before is None else query.where(jobs.c.serial < before)
    rows = connection.execute(query.order_by(jobs.c.serial.desc()).limit(limit))
    return [brief_of(columns_of(row)) for row in rows]


def counts(connection: Connection) -> dict[tuple[str, str], int]:
    """Return how many jobs there are by lane and state."""
    query = select(jobs.c.lane, jobs.c.state, func.count()).group_by(jobs.c.lane, jobs.c.state)
    return {(lane, state): number for lane, state, number in connection.execute(query)}


def events_after(
    connection: Connection, identifier: str, after: int, limit: int | None
) -> list[LoggedEvent]:
    """Return a job's events with numbers above `after`, in order."""
    query = _AFTER if limit is None else _AFTER.limit(limit)
    given = {"job_id": identifier, "after": after}
    return [_event(row) for row in connection.execute(query, given)]


def last_event(connection: Connection, identifier: str, type_: str) -> LoggedEvent | None:
    """Return the newest event of a type, if there is one."""
    row = connection.execute(_NEWEST, {"job_id": identifier, "of_type": type_}).first()
    return None if row is None else _event(row)


def job_of(columns: Mapping[str, Any]) -> Job:
    """Return the job of the columns of its tables."""
    return Job(**_decoded(columns))


def brief_of(columns: Mapping[str, Any]) -> JobSummary:
    """Return the job of the columns of its tables, as lists have it."""
    return JobSummary(**_decoded(columns))


def columns_of(row: Row[Any]) -> dict[str, Any]:
    """Return the columns of a row by name."""
    return dict(row._mapping)  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]  (public)


def _one(connection: Connection, query: Select[Any], identifier: str) -> dict[str, Any]:
    row = connection.execute(query, {"job_id": identifier}).first()
    if row is None:
        raise UnknownJob.of(identifier)
    return columns_of(row)


def _decoded(columns: Mapping[str, Any]) -> dict[str, Any]:
    fields = {_FIELDS.get(name, name): content for name, content in columns.items()}
    for name in ("created_at", "started_at", "finished_at"):
        fields[name] = datetime.fromisoformat(fields[name]) if fields[name] else None
    fields["state"] = JobState(fields["state"])
    return fields


def _event(row: Row[Any]) -> LoggedEvent:
    return LoggedEvent(**columns_of(row))
