"""How a job changes its state: each change with the event that tells of it."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from sqlalchemy import Connection, bindparam

from service.jobs.job import FINISHED, JobText, LoggedEvent
from service.jobs.json_text import Encoded, encode
from service.jobs.states import JobEvent, JobState, advance, sources
from service.jobs.store.event_log import append_events, update_in
from service.jobs.store.prepared import Prepared
from service.jobs.store.queries import now, summary_of
from service.jobs.store.tables import jobs

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
    [logged] = append_events(connection, identifier, row["num_events"], [(name, dict(data))])
    # A prepared statement has booleans as the database has them.
    columns = {**row, "is_cancel_requested": bool(row["is_cancel_requested"])}
    return Transition(logged, row["attempts"], columns["is_cancel_requested"], columns)


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
    columns |= {"state": advance(before[0], event).value, "num_events": jobs.c.num_events + 1}
    return Prepared(update_in(before).values(columns).returning(*jobs.c))
