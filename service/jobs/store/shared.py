"""What servers that share a database do one after the other, in their transactions."""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, bindparam, func, select

from service.jobs.job import CONTROLS, LoggedEvent
from service.jobs.json_text import Encoded
from service.jobs.states import JobState
from service.jobs.store.event_log import append_events, reserve_events
from service.jobs.store.queries import read_last_event
from service.jobs.store.sql.database import in_transaction
from service.jobs.store.sql.tables import jobs

_NOTHING = Encoded("{}")
_QUEUED = "queued"
# Any two numbers will do.
_TAKE_TURN = select(func.pg_advisory_xact_lock(0x5761, 0x7970))
_NUM_QUEUED = select(func.count()).where(
    jobs.c.queue == bindparam("in_queue"), jobs.c.state == JobState.QUEUED.value
)


def count_queued(connection: Connection, queue: str, more: int) -> int:
    """Return how many jobs of a queue wait, before some more are added to it.

    No other server adds one until the commit. A transaction counts once, and what it adds itself.
    """
    known = in_transaction(connection, _QUEUED)
    if queue not in known:
        if connection.dialect.name == "postgresql":  # SQLite has one writer
            connection.execute(_TAKE_TURN)
        known[queue] = connection.execute(_NUM_QUEUED, {"in_queue": queue}).scalar_one()
    before = int(known[queue])
    known[queue] += more
    return before


def set_controls(
    connection: Connection, identifier: str, changes: Mapping[str, Any]
) -> list[LoggedEvent]:
    """Append an event with all controls of a job that waits or runs, some of which change.

    Returns:
        The event; none if the job has ended.
    """
    # This locks the job: no other server sets any meanwhile.
    first = reserve_events(connection, identifier, [(CONTROLS, _NOTHING)], may_wait=True)
    if first is None:
        return []
    before = read_last_event(connection, identifier, CONTROLS)
    controls = {**(before.data if before else {}), **changes}
    return append_events(connection, identifier, first, [(CONTROLS, controls)])
