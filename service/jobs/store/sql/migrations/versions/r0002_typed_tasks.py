"""Jobs are stored by stable names of tasks, lists have what they show, executions exclude others.

Tasks had the paths of their functions for names. What lists show of a job was not written by
versions before 0.1, and not by every version for how a job ended.
"""

import json
from typing import Any

import sqlalchemy as sa
from alembic import op

from service.jobs.json_text import encode

revision = "0002"
down_revision = "0001"

_NAMES = {
    "service.tasks.plan:plan_motion": "plan",
    "service.tasks.reverse:reverse_motion": "reverse",
    "service.tasks.regions:grow": "grow_regions",
    "service.tasks.execute:execute": "execute",
}
# The large members of payload, result and failure, which lists leave out.
_OF_PLANS = (("motion",), ("result", "polynomial", "graph"), ("evidence.graph",))
_LARGE: dict[str, tuple[tuple[str, ...], ...]] = {
    "plan": _OF_PLANS,
    "reverse": _OF_PLANS,
    "grow_regions": ((), ("result.regions", "result.portals"), ()),
    "execute": (("trajectory",), (), ()),
}
_PARTS = ("payload", "result", "failure")
# Jobs that are read at once: each may be megabytes.
_AT_ONCE = 16

_jobs = sa.table("jobs", *map(sa.column, ("serial", "id", "task", "state")))
_bodies = sa.table("job_bodies", *map(sa.column, ("job", *_PARTS)))
_briefs = sa.table("job_briefs", *map(sa.column, ("job", *_PARTS)))


def upgrade() -> None:
    """Rename tasks, write what is missing of what lists show, make the index."""
    connection = op.get_bind()
    for former, name in _NAMES.items():
        connection.execute(sa.update(_jobs).where(_jobs.c.task == former).values(task=name))
    last = 0
    while found := _incomplete(connection, last):
        _write(connection, found)
        last = found[-1]
    is_open = sa.text("lane = 'execution' AND state IN ('queued', 'running')")
    op.create_index(
        "one_open_execution_of_scene",
        "jobs",
        ["scene"],
        unique=True,
        sqlite_where=is_open,
        postgresql_where=is_open,
        if_not_exists=True,
    )


def _incomplete(connection: sa.Connection, last: int) -> list[int]:
    """Return serials of some jobs behind a serial whose brief is not what it should be."""
    is_incomplete = sa.or_(
        _briefs.c.job.is_(None),
        (_jobs.c.state == "succeeded") & _briefs.c.result.is_(None),
        _jobs.c.state.in_(["failed", "canceled"]) & _briefs.c.failure.is_(None),
    )
    query = sa.select(_jobs.c.serial).join(_briefs, _briefs.c.job == _jobs.c.id, isouter=True)
    query = query.where(is_incomplete, _jobs.c.serial > last).order_by(_jobs.c.serial)
    return list(connection.execute(query.limit(_AT_ONCE)).scalars())


def _write(connection: sa.Connection, serials: list[int]) -> None:
    query = sa.select(_jobs.c.task, _bodies).join(_bodies, _bodies.c.job == _jobs.c.id)
    rows: list[dict[str, Any]] = []
    for row in connection.execute(query.where(_jobs.c.serial.in_(serials))).mappings():
        large = _LARGE.get(row["task"], ((), (), ()))
        parts = zip(_PARTS, large, strict=True)
        rows.append({
            "job": row["job"],
            **{part: _shortened(row[part], members) for part, members in parts},
        })
    if rows:
        known = [row["job"] for row in rows]
        connection.execute(sa.delete(_briefs).where(_briefs.c.job.in_(known)))
        connection.execute(sa.insert(_briefs), rows)


def _shortened(text: str | None, members: tuple[str, ...]) -> str | None:
    """Return the text of JSON without some of its members, named by dotted paths."""
    if text is None or not members:
        return text
    content = json.loads(text)
    for member in members:
        *path, last = member.split(".")
        inner = content
        for name in path:
            inner = inner.get(name) if isinstance(inner, dict) else None
        if isinstance(inner, dict):
            inner.pop(last, None)
    return encode(content)
