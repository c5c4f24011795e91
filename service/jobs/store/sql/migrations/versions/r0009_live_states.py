"""Scenes have a live state: where executions left their robots is no revision any more."""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"

# Of joints with several; others have one.
_NUM_POSITIONS = {"planar": 3, "floating": 7}
# The last execution of each scene, if it ended after the latest revision was made: older versions
# wrote that revision when the scene was next asked for.
_UNSETTLED = """
SELECT jobs.id, jobs.scene, jobs.finished_at, scenes.serial
FROM jobs JOIN scenes ON scenes.id = jobs.scene
WHERE jobs.sequence IN (
    SELECT MAX(sequence) FROM jobs WHERE queue = 'execution' GROUP BY scene
) AND scenes.revision = (SELECT MAX(other.revision) FROM scenes other WHERE other.id = scenes.id)
AND jobs.finished_at > scenes.created_at
"""
_STATUS = """
SELECT data FROM job_events WHERE job = :job AND type = 'status' ORDER BY number DESC LIMIT 1
"""
_SUMMARY = "SELECT CAST(summary AS TEXT) FROM scenes WHERE serial = :serial"


def upgrade() -> None:
    """Make the table, and fill it with what executions left that no revision says."""
    states = op.create_table(
        "scene_states",
        sa.Column("scene", sa.String(64), primary_key=True),
        sa.Column("robot", sa.String(256), primary_key=True),
        sa.Column("positions", sa.Text, nullable=False),
        sa.Column("status", sa.String(12), nullable=False),
        sa.Column("revision", sa.Integer, nullable=True),
        sa.Column("execution", sa.String(64), nullable=True),
        sa.Column("updated_at", sa.String(40), nullable=False),
    )
    connection = op.get_bind()
    for job in connection.execute(sa.text(_UNSETTLED)).all():
        for robot, positions in _measured(job):
            row = {
                "scene": job.scene,
                "robot": robot,
                "positions": json.dumps(positions),
                "status": "at_rest",
                "execution": job.id,
                "updated_at": job.finished_at,
            }
            connection.execute(sa.insert(states).values(**row))


def _measured(job: Any) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the robots that an execution moved, and where it has left their joints."""
    connection = op.get_bind()
    status = connection.execute(sa.text(_STATUS), {"job": job.id}).scalar()
    if status is None:  # it never moved
        return
    payload = sa.text("SELECT payload FROM job_bodies WHERE job = :job")
    name = json.loads(connection.execute(payload, {"job": job.id}).scalar_one())["group"]
    summary = connection.execute(sa.text(_SUMMARY), {"serial": job.serial}).scalar_one()
    for group in json.loads(summary)["groups"]:
        if group["name"] == name:
            yield name.partition("::")[0], _by_joint(group, json.loads(status)["positions"])


def _by_joint(group: Mapping[str, Any], values: Sequence[float]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    at = 0
    for joint in group["joints"]:
        size = _NUM_POSITIONS.get(joint["type"], 1)
        own = list(values[at : at + size])
        found[joint["name"].partition("::")[2]] = own[0] if size == 1 else own
        at += size
    return found
