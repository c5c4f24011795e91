"""Batches as a database has them: how many of the jobs of each are where."""

from collections import defaultdict
from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, bindparam, func, select

from service.jobs.job import BatchSummary
from service.jobs.store.sql.tables import jobs

_STATES = (
    select(
        jobs.c.batch,
        jobs.c.state,
        func.count(),
        func.min(jobs.c.created_at),
        func.max(jobs.c.finished_at),
    )
    .where(jobs.c.batch.in_(bindparam("ids", expanding=True)))
    .group_by(jobs.c.batch, jobs.c.state)
)


def read_batches(
    connection: Connection,
    queue: str,
    wanted: Mapping[str, str | None],
    *,
    before: int | None,
    limit: int,
) -> list[BatchSummary]:
    """Return batches of jobs as `JobQueries.batches` does."""
    conditions = [jobs.c[name] == content for name, content in wanted.items() if content]
    first = func.min(jobs.c.sequence)
    query = select(jobs.c.batch, first).where(jobs.c.batch.is_not(None)).group_by(jobs.c.batch)
    if conditions:
        such = select(jobs.c.batch).where(jobs.c.queue == queue, *conditions)
        query = query.where(jobs.c.batch.in_(such.where(jobs.c.batch.is_not(None))))
    query = query if before is None else query.having(first < before)
    rows = connection.execute(query.order_by(first.desc()).limit(limit)).all()
    states = defaultdict[str, list[Any]](list)
    for name, *state in connection.execute(_STATES, {"ids": [r[0] for r in rows]}):
        states[name].append(state)
    # One that was deleted between both looks has no states.
    return [BatchSummary.of(name, n, states[name]) for name, n in rows if name in states]
