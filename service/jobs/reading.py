"""What is asked of the tables of jobs, and rows as values."""

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import ColumnElement, Connection, Row, Select, Table, func, select

from service.jobs.json_text import Encoded
from service.jobs.records import Job, JobBrief, LoggedEvent, bodies, briefs, events, jobs, makers
from service.jobs.states import JobState

_MAX_STAGE = 40


def _jobs_with(content: Table) -> Select[Any]:
    columns = (content.c.payload, content.c.result, content.c.failure, makers.c.made_by)
    joined = select(jobs, *columns).join(content, content.c.job == jobs.c.id)
    return joined.join(makers, makers.c.job == jobs.c.id, isouter=True)


_WHOLE, _BRIEF = _jobs_with(bodies), _jobs_with(briefs)


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
    return [Job(**_fields(row)) for row in rows]


def unfinished(connection: Connection) -> list[Job]:
    """Return every job that is queued or running, oldest first."""
    states = [state.value for state in JobState if not state.is_final]
    return jobs_where(connection, jobs.c.state.in_(states))


def page(
    connection: Connection, wanted: Mapping[str, str | None], before: int | None, limit: int
) -> list[JobBrief]:
    """Return jobs whose columns are as wanted, newest first, with a serial below `before`."""
    query = _BRIEF
    for name, content in wanted.items():
        query = query if content is None else query.where(jobs.c[name] == content)
    query = query if before is None else query.where(jobs.c.serial < before)
    rows = connection.execute(query.order_by(jobs.c.serial.desc()).limit(limit))
    return [JobBrief(**_fields(row)) for row in rows]


def counts(connection: Connection) -> dict[tuple[str, str], int]:
    """Return how many jobs there are by lane and state."""
    query = select(jobs.c.lane, jobs.c.state, func.count()).group_by(jobs.c.lane, jobs.c.state)
    return {(lane, state): number for lane, state, number in connection.execute(query)}


def events_after(
    connection: Connection, identifier: str, after: int, limit: int | None
) -> list[LoggedEvent]:
    """Return a job's events with numbers above `after`, in order."""
    query = select(events).where(events.c.job == identifier, events.c.number > after)
    query = query.order_by(events.c.number).limit(limit)
    return [_event(row) for row in connection.execute(query)]


def last_event(connection: Connection, identifier: str, type_: str) -> LoggedEvent | None:
    """Return the newest event of a type, if there is one."""
    query = select(events).where(events.c.job == identifier, events.c.type == type_)
    row = connection.execute(query.order_by(events.c.number.desc()).limit(1)).first()
    return None if row is None else _event(row)


def _fields(row: Row[Any]) -> dict[str, Any]:
    fields = _columns(row)
    for name in ("created_at", "started_at", "finished_at"):
        fields[name] = datetime.fromisoformat(fields[name]) if fields[name] else None
    fields["state"] = JobState(fields["state"])
    return fields


def _event(row: Row[Any]) -> LoggedEvent:
    return LoggedEvent(**_columns(row))


def _columns(row: Row[Any]) -> dict[str, Any]:
    return dict(row._mapping)  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]  (public)
