"""Moving a job from state to state, and the event that tells of it, in one transaction."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from sqlalchemy import Connection, Update, bindparam, insert, or_, update

from service.jobs.json_text import Encoded, encode
from service.jobs.prepared import Prepared
from service.jobs.reading import brief_of, columns_of, decoded, now, progress_in
from service.jobs.states import JobEvent, JobState, advance, sources
from service.jobs.tables import FINISHED, JobText, LoggedEvent, events, jobs

_EVENT_NAMES = {
    JobEvent.START: "started",
    JobEvent.REQUEUE: "requeued",
    JobEvent.SUCCEED: FINISHED,
    JobEvent.FAIL: FINISHED,
    JobEvent.CANCEL: FINISHED,
}
_ADD_EVENT = Prepared(insert(events), "job", "number", "type", "data", "at")


@dataclass(frozen=True)
class Transition:
    """What came of a transition.

    Attributes:
        event: That tells of it.
        attempts: How often the job was started by now.
        is_cancel_requested: Whether somebody wants its end.
        columns: Of the job in its table, as they are now.
    """

    event: LoggedEvent
    attempts: int
    is_cancel_requested: bool
    columns: Mapping[str, Any]


def apply_event(
    connection: Connection,
    identifier: str,
    happened: JobEvent,
    changes: Mapping[str, Any],
    told: Mapping[str, Any],
    only: JobState | None = None,
) -> Transition | None:
    """Apply an event if the job's state allows it, and log it; None if the job has moved on.

    Args:
        connection: In a transaction.
        identifier: Of the job.
        happened: The event.
        changes: More columns that change; `more_attempts` are added to those that there were.
        told: What the logged event says.
        only: The state that the job must be in, if not any that allows the event.
    """
    after = advance(_before(happened, only)[0], happened)
    given = {f"new_{name}": content for name, content in changes.items()}
    if after.is_final:
        given["new_finished_at"] = now()
        told = {"state": after.value, **told}
    statement = _transition(happened, only, tuple(given))
    row = statement(connection, whose=identifier, **given).first()
    if row is None:
        return None
    name = _EVENT_NAMES[happened]
    [logged] = append_events(connection, identifier, row.num_events, [(name, dict(told))])
    # A prepared statement has booleans as the database has them.
    columns = {**columns_of(row), "is_cancel_requested": bool(row.is_cancel_requested)}
    return Transition(logged, row.attempts, columns["is_cancel_requested"], columns)


def ended_job(
    moved: Transition,
    payload: Mapping[str, Any],
    made_by: Mapping[str, str],
    result: Encoded | None,
    brief: Any,
) -> JobText:
    """Return a job that has just ended as it would be read.

    Args:
        moved: Its last move.
        payload: Its own.
        made_by: The versions of what ran it.
        result: Whole, None if it has none.
        brief: What lists show of the result.
    """
    failure = json.loads(encode(moved.event.data.get("failure")))
    content = {"payload": payload, "result": brief, "failure": failure, "made_by": made_by}
    return JobText(brief_of({**moved.columns, **content}), result)


def reserve_events(
    connection: Connection,
    identifier: str,
    told: Sequence[tuple[str, Encoded]],
    *,
    may_wait: bool,
) -> int | None:
    """Return the first number for events of a job, None if it has ended; its stage is theirs.

    Args:
        connection: In a transaction.
        identifier: Of the job.
        told: Types and data.
        may_wait: Whether the job may also be queued.
    """
    changes: dict[str, Any] = {}
    for _, data in told:
        changes |= progress_in(decoded(data))
    given = {f"new_{name}": content for name, content in changes.items()}
    statement = _reservation(tuple(given), may_wait=may_wait)
    row = statement(connection, whose=identifier, more=len(told), **given).first()
    return None if row is None else row.num_events - len(told) + 1


def append_events(
    connection: Connection,
    identifier: str,
    first: int,
    told: Sequence[tuple[str, Encoded | dict[str, Any]]],
) -> list[LoggedEvent]:
    """Append events whose numbers have been reserved by adding to `num_events`.

    Args:
        connection: In the transaction that reserved them.
        identifier: Of the job.
        first: The first number.
        told: Types and data.
    """
    at = now()
    texts = [data.text if isinstance(data, Encoded) else encode(data) for _, data in told]
    rows = [
        {"job": identifier, "number": first + i, "type": type_, "data": text, "at": at}
        for i, ((type_, _), text) in enumerate(zip(told, texts, strict=True))
    ]
    _ADD_EVENT.many(connection, rows)
    return [
        LoggedEvent(identifier, first + i, type_, decoded(data), at)
        for i, (type_, data) in enumerate(told)
    ]


def _before(happened: JobEvent, only: JobState | None) -> tuple[JobState, ...]:
    return sources(happened) if only is None else (only,)


@cache
def _transition(happened: JobEvent, only: JobState | None, given: tuple[str, ...]) -> Prepared:
    before = _before(happened, only)
    columns: dict[str, Any] = {name.removeprefix("new_"): bindparam(name) for name in given}
    more_attempts = columns.pop("more_attempts", None)
    if more_attempts is not None:
        columns["attempts"] = jobs.c.attempts + more_attempts
    columns |= {"state": advance(before[0], happened).value, "num_events": jobs.c.num_events + 1}
    return Prepared(_update_in(before).values(columns).returning(*jobs.c))


@cache
def _reservation(given: tuple[str, ...], *, may_wait: bool) -> Prepared:
    states = [state for state in JobState if not state.is_final] if may_wait else [JobState.RUNNING]
    columns: dict[str, Any] = {name.removeprefix("new_"): bindparam(name) for name in given}
    columns["num_events"] = jobs.c.num_events + bindparam("more")
    return Prepared(_update_in(states).values(columns).returning(jobs.c.num_events))


def _update_in(states: Sequence[JobState]) -> Update:
    is_in = or_(*(jobs.c.state == state.value for state in states))
    return update(jobs).where(jobs.c.id == bindparam("whose"), is_in)
