"""What a replay of a scene shows: the motions that executions carried out in it, in order."""

from service.errors import NotFinished
from service.executions.models import ExecutionStatus
from service.executions.position import last_status
from service.executions.tasks import ExecutionWork
from service.jobs.job import JobSummary
from service.plans.tasks import ShownWork
from service.scene_jobs import SceneJobs


async def executed_motions(jobs: SceneJobs, scene: str, most: int) -> list[ShownWork]:
    """Return the last motions that were carried out in a scene, oldest first.

    Each is shown in the revision that it was carried out in, and as far as it went.

    Raises:
        NotFinished: Nothing has moved in the scene yet.
    """
    found: list[ShownWork] = []
    async for job in jobs.newest("execution", scene=scene):
        if len(found) == most:
            break
        status = await last_status(jobs, job)
        if job.finished_at is not None and status is not None:
            found.append(await _motion(jobs, job, status))
    if not found:
        message = f"no execution has moved anything in scene {scene} and ended: nothing to replay"
        raise NotFinished(message, {"id": scene, "state": "unmoved"})
    return found[::-1]


async def _motion(jobs: SceneJobs, summary: JobSummary, status: ExecutionStatus) -> ShownWork:
    job = await jobs.job("execution", summary.id)  # lists have no trajectory
    work = ExecutionWork.model_validate(job.payload)
    is_whole = job.state == "succeeded"
    title = work.request.title or f"{work.group} moves"
    return ShownWork(
        library=work.library,
        scene=work.scene,
        group=work.group,
        trajectory=work.trajectory,
        title=title if is_whole else f"{title} ({job.state})",
        until=None if is_whole else status.time,
    )
