"""How a job changes its state: each change with the event that tells of it."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from sqlalchemy import Connection, bindparam

from service.jobs.job import FINISHED, JobText, LoggedEvent, PendingEvent
from service.jobs.json_text import Encoded, encode
from service.jobs.states import JobEvent, JobState, advance, sources
from service.jobs.store.event_log import append_events, progress_of, update_in
from service.jobs.store.queries import now, summary_of
from service.jobs.store.sql.prepared import Prepared
from service.jobs.store.sql.tables import jobs

_EVENT_NAMES = {
    JobEvent.START: "started",
    JobEvent.REQUEUE: "requeued",
    JobEvent.SUCCEED: FINISHED,
    JobEvent.FAIL: FINISHED,
    JobEvent.CANCEL: FINISHED,
}


@dataclass(frozen=True)
class Transition:
    """A change of a job's state, as it was written.

    Attributes:
        event: That tells of it.
        attempts: How often the job was started by now.
        is_cancel_requested: Whether its end was requested.
        columns: Of the job in its table, as they are now.
        events_before: That were written with it, and come before it.
    """

    event: LoggedEvent
    attempts: int
    is_cancel_requested: bool
    columns: Mapping[str, Any]
    events_before: Sequence[LoggedEvent] = ()


@dataclass(frozen=True)
class Change:
    """A change of a job's state that is to be written.

    Attributes:
        event: That changes it.
        columns: More of the job that change; `more_attempts` are added to those that there were.
        data: Of the logged event.
        only: The state that the job must be in, if not any that allows the event.
        events_before: That a running job has sent, to be logged before it.
    """

    event: JobEvent
    columns: Mapping[str, Any] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)
    only: JobState | None = None
    events_before: Sequence[PendingEvent] = ()


def apply_change(connection: Connection, identifier: str, change: Change) -> Transition | None:
    """Change a job's state if that allows it, and log it; None if the job has moved on.

    Args:
        connection: In a transaction.
        identifier: Of the job.
        change: What is to happen to it.
    """
    event, only, data = change.event, change.only, change.data
    after = advance(_before(event, only)[0], event)
    every = {**progress_of(change.events_before), **change.columns}
    given = {f"new_{name}": content for name, content in every.items()}
    if after.is_final:
        given["new_finished_at"] = now()
        data = {"state": after.value, **data}
    statement = _transition(event, only, tuple(given))
    more = len(change.events_before) + 1
    row = statement(connection, job_id=identifier, more_events=more, **given).first()
    if row is None:
        return None
    own = (_EVENT_NAMES[event], dict(data))
    first = row["num_events"] - more + 1
    *before, logged = append_events(connection, identifier, first, [*change.events_before, own])
    # A prepared statement has booleans as the database has them.
    columns = {**row, "is_cancel_requested": bool(row["is_cancel_requested"])}
    is_requested = columns["is_cancel_requested"]
    return Transition(logged, row["attempts"], is_requested, columns, before)


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


def _before(event: JobEvent, only: JobState | None) -> tuple[JobState, ...]:
    return sources(event) if only is None else (only,)


@cache
def _transition(event: JobEvent, only: JobState | None, given: tuple[str, ...]) -> Prepared:
    before = _before(event, only)
    columns: dict[str, Any] = {name.removeprefix("new_"): bindparam(name) for name in given}
    more_attempts = columns.pop("more_attempts", None)
    if more_attempts is not None:
        columns["attempts"] = jobs.c.attempts + more_attempts
    num_events = jobs.c.num_events + bindparam("more_events")
    columns |= {"state": advance(before[0], event).value, "num_events": num_events}
    return Prepared(update_in(before).values(columns).returning(*jobs.c))
