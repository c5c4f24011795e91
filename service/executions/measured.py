"""What executions measure goes into the live state of their scene: while they move, and at the end.

The end is kept in the transaction that ends the job, whatever ended it and whichever server: what
was measured last is never lost, and what is told of the end is told after it.
"""

import asyncio
from dataclasses import replace
from datetime import datetime

from sqlalchemy import Connection, select

from planning.domain.robot.joints import JointType
from service.executions.models import ExecutionState
from service.executions.robot_status import status_after
from service.executions.tasks import EXECUTE, ExecutionOutline
from service.jobs.job import FINISHED, JobSummary, LoggedEvent
from service.jobs.service import JobService
from service.jobs.states import JobState
from service.jobs.store.queries import read_last_event
from service.jobs.store.sql.tables import summaries
from service.scenes.job_spec import PREFIXES
from service.scenes.live import Motion, by_joint, joint_types
from service.scenes.store.live_rows import write_measured
from service.scenes.store.rows import read_groups

# In one scene; there are mostly none.
_MOST = 100
_IDS = f"{PREFIXES[EXECUTE.queue]}_"
STATUS = "status"


async def open_motions(scene: str, *, jobs: JobService) -> list[Motion]:
    """Return the executions of a scene that have not ended, and what they have measured so far."""
    found: list[Motion] = []
    for state in (JobState.QUEUED, JobState.RUNNING):
        page = await jobs.page(EXECUTE.queue, _MOST, None, state=state, scene=scene)
        found += await asyncio.gather(*(_motion(job, jobs) for job in page.jobs))
    return found


async def _motion(job: JobSummary, jobs: JobService) -> Motion:
    event = await jobs.last_recorded(job, STATUS)
    work = ExecutionOutline.model_validate(job.payload)
    robots = list(work.robots)
    motion = Motion(job.id, work.group, job.sequence, robots, work.joints, job.created_at)
    return motion if event is None else told(motion, event)


def told(motion: Motion, event: LoggedEvent) -> Motion:
    """Return a motion after a `status` of its execution."""
    velocities = event.data.get("velocities")
    return replace(
        motion,
        positions=by_joint(motion.joints, event.data["positions"]),
        velocities=velocities and by_joint(motion.joints, velocities, are_velocities=True),
        number=event.number,
        held=event.data.get("held", ()),
        updated_at=datetime.fromisoformat(event.at),
    )


def keep_end(connection: Connection, event: LoggedEvent) -> None:
    """Keep what was measured last, in the transaction that ends an execution.

    Args:
        connection: In that transaction.
        event: Of a job that changes its state; others than executions that end are not heeded.
    """
    if event.type != FINISHED or not event.job.startswith(_IDS):
        return
    status = read_last_event(connection, event.job, STATUS)
    if status is None:  # it never moved
        return
    query = select(summaries.c.payload).where(summaries.c.job == event.job)
    work = ExecutionOutline.model_validate(connection.execute(query).scalar_one())
    joints = work.joints or _joints_of(connection, work.scene_id, work.group)
    last = ExecutionState(status.data["state"])
    write_measured(
        connection,
        work.scene_id,
        by_joint(joints, status.data["positions"]),
        status_after(work.request.driver, last, event.data.get("failure")),
        event.job,
        datetime.fromisoformat(event.at),
    )


def _joints_of(connection: Connection, scene: str, name: str) -> dict[str, JointType]:
    """Return the joints of a group, for an execution that an older version has begun."""
    for group in read_groups(connection, scene):
        if group.name == name:
            return joint_types(group)
    return {}
