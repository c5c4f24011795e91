"""How events enter the log of a job, whose stage and progress are those of its last ones."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from sqlalchemy import Connection, Update, bindparam, insert, or_, update

from service.jobs.job import LoggedEvent, PendingEvent
from service.jobs.json_text import Encoded, decoded, encode
from service.jobs.states import JobState
from service.jobs.store.queries import now
from service.jobs.store.sql.notifications import note_change
from service.jobs.store.sql.prepared import Prepared
from service.jobs.store.sql.tables import events, jobs

_MAX_STAGE = 40
# `stage` and `progress`.
_NUM_PROGRESS = 2
_ADD_EVENT = Prepared(insert(events), "job", "number", "type", "data", "at")


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
    given = {f"new_{name}": content for name, content in progress_of(new_events).items()}
    statement = _reservation(tuple(given), may_wait=may_wait)
    row = statement(connection, job_id=identifier, more=len(new_events), **given).first()
    return None if row is None else int(row["num_events"]) - len(new_events) + 1


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
    note_change(connection, identifier)
    return [
        LoggedEvent(identifier, first + i, type_, data, at)
        for i, (type_, data) in enumerate(new_events)
    ]


def update_in(states: Sequence[JobState]) -> Update:
    """Return an update of a job, `job_id`, if it is in one of some states."""
    is_in = or_(*(jobs.c.state == state.value for state in states))
    return update(jobs).where(jobs.c.id == bindparam("job_id"), is_in)


@cache
def _reservation(given: tuple[str, ...], *, may_wait: bool) -> Prepared:
    states = [state for state in JobState if not state.is_final] if may_wait else [JobState.RUNNING]
    columns: dict[str, Any] = {name.removeprefix("new_"): bindparam(name) for name in given}
    columns["num_events"] = jobs.c.num_events + bindparam("more")
    return Prepared(update_in(states).values(columns).returning(jobs.c.num_events))


def progress_of(new_events: Sequence[PendingEvent]) -> dict[str, Any]:
    """Return the columns of a job that its events change, as the last ones have them."""
    changes: dict[str, Any] = {}
    for _, data in reversed(new_events):
        changes = {**_progress_in(decoded(data)), **changes}
        if len(changes) == _NUM_PROGRESS:
            break
    return changes


def _progress_in(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the columns of a job that an event changes: `stage` and `progress` in its data."""
    changes: dict[str, Any] = {}
    stage, progress = data.get("stage"), data.get("progress")
    if isinstance(stage, str):
        changes["stage"] = stage[:_MAX_STAGE]
    if isinstance(progress, int | float):
        changes["progress"] = min(1.0, max(0.0, float(progress)))
    return changes
