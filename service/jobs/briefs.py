"""Briefs of jobs that an older version recorded, or ended: written once, when a store is opened."""

import logging

from sqlalchemy import Connection, Engine, delete, insert, or_, select

from service.jobs.outline import without
from service.jobs.states import JobState
from service.jobs.tables import bodies, jobs, summaries
from service.jobs.task import outline_of

# Jobs that are read at once: each may be megabytes.
_AT_ONCE = 16
_log = logging.getLogger(__name__)


def fill_summaries(engine: Engine) -> None:
    """Write the briefs that are missing, or that lack how their job ended.

    Every portion is a transaction of its own: whoever interrupts it loses nothing.
    """
    count = last = 0
    while True:
        with engine.begin() as connection:
            found = _incomplete(connection, last)
            if found:
                _write(connection, [serial for serial, _ in found])
        if not found:
            break
        if not count:
            _log.info("writing what lists show of jobs that an older version recorded")
        count, last = count + len(found), found[-1][0]
    if count:
        _log.info("wrote what lists show of %d jobs", count)


def _incomplete(connection: Connection, last: int) -> list[tuple[int, str]]:
    """Return serials and ids of some jobs behind a serial whose brief is not what it should be."""
    has_succeeded = jobs.c.state == JobState.SUCCEEDED.value
    has_failed = jobs.c.state.in_([JobState.FAILED.value, JobState.CANCELED.value])
    is_incomplete = or_(
        summaries.c.job.is_(None),
        has_succeeded & summaries.c.result.is_(None),
        has_failed & summaries.c.failure.is_(None),
    )
    query = select(jobs.c.serial, jobs.c.id).join(
        summaries, summaries.c.job == jobs.c.id, isouter=True
    )
    query = query.where(is_incomplete, jobs.c.serial > last).order_by(jobs.c.serial)
    return [(row.serial, row.id) for row in connection.execute(query.limit(_AT_ONCE))]


def _write(connection: Connection, serials: list[int]) -> None:
    query = select(jobs.c.task, bodies).join(bodies, bodies.c.job == jobs.c.id)
    rows = []
    for row in connection.execute(query.where(jobs.c.serial.in_(serials))):
        outline = outline_of(row.task)
        rows.append({
            "job": row.job,
            "payload": without(row.payload, outline.payload),
            "result": without(row.result, outline.result),
            "failure": without(row.failure, outline.failure),
        })
    if rows:
        connection.execute(
            delete(summaries).where(summaries.c.job.in_([row["job"] for row in rows]))
        )
        connection.execute(insert(summaries), rows)
