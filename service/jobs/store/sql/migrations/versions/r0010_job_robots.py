"""Executions of different robots of one scene are open at once: each has the robots it moves."""

import json

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"

_OPEN = """
SELECT jobs.id, job_bodies.payload FROM jobs JOIN job_bodies ON job_bodies.job = jobs.id
WHERE jobs.queue = 'execution' AND jobs.state IN ('queued', 'running')
"""


def upgrade() -> None:
    """Make the tables, with the robots of what is open; one of a scene was open at a time."""
    op.drop_index("one_open_execution_of_scene", "jobs")
    op.create_table(
        "scene_entries",
        sa.Column("scene", sa.String(64), primary_key=True),
        sa.Column("number", sa.BigInteger, nullable=False),
    )
    robots = op.create_table(
        "job_robots",
        sa.Column("job", sa.String(64), primary_key=True),
        sa.Column("robot", sa.String(256), primary_key=True),
        sa.Column("is_waiting", sa.Boolean, nullable=False),
    )
    op.create_index("robots_waited_for", "job_robots", ["is_waiting", "job"])
    connection = op.get_bind()
    for job in connection.execute(sa.text(_OPEN)).all():
        payload = json.loads(job.payload)
        names = payload.get("joints") or [payload["group"]]
        for robot in {name.partition("::")[0] for name in names}:
            row = {"job": job.id, "robot": robot, "is_waiting": False}
            connection.execute(sa.insert(robots).values(**row))
