"""Moving a job from state to state, and the event that tells of it, in one transaction."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, insert, update

from service.jobs.json_text import Encoded
from service.jobs.reading import decoded, now
from service.jobs.records import FINISHED, LoggedEvent, events, jobs
from service.jobs.states import JobEvent, JobState, advance, sources

_EVENT_NAMES = {
    JobEvent.START: "started",
    JobEvent.REQUEUE: "requeued",
    JobEvent.SUCCEED: FINISHED,
    JobEvent.FAIL: FINISHED,
    JobEvent.CANCEL: FINISHED,
}


@dataclass(frozen=True)
class Moved:
    """What came of a transition.

    Attributes:
        event: That tells of it.
        attempts: How often the job was started by now.
        is_cancel_requested: Whether somebody wants its end.
    """

    event: LoggedEvent
    attempts: int
    is_cancel_requested: bool


def move(
    connection: Connection,
    identifier: str,
    happened: JobEvent,
    changes: Mapping[str, Any],
    told: Mapping[str, Any],
    only: JobState | None = None,
) -> Moved | None:
    """Apply an event if the job's state allows it, and log it; None if the job has moved on.

    Args:
        connection: In a transaction.
        identifier: Of the job.
        happened: The event.
        changes: More columns that change.
        told: What the logged event says.
        only: The state that the job must be in, if not any that allows the event.
    """
    before = sources(happened) if only is None else (only,)
    after = advance(before[0], happened)
    columns = {"state": after.value, "num_events": jobs.c.num_events + 1, **changes}
    if after.is_final:
        columns["finished_at"] = now()
        told = {"state": after.value, **told}
    is_allowed = (jobs.c.id == identifier) & jobs.c.state.in_([state.value for state in before])
    seen = (jobs.c.num_events, jobs.c.attempts, jobs.c.is_cancel_requested)
    statement = update(jobs).where(is_allowed).values(columns).returning(*seen)
    row = connection.execute(statement).first()
    if row is None:
        return None
    name = _EVENT_NAMES[happened]
    [logged] = log(connection, identifier, row.num_events, [(name, dict(told))])
    return Moved(logged, row.attempts, row.is_cancel_requested)


def log(
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
    rows = [
        {"job": identifier, "number": first + i, "type": type_, "data": data, "at": at}
        for i, (type_, data) in enumerate(told)
    ]
    connection.execute(insert(events), rows)
    return [
        LoggedEvent(identifier, first + i, type_, decoded(data), at)
        for i, (type_, data) in enumerate(told)
    ]
