"""What a replay of a scene shows: the motions that executions carried out in it, in order."""

from typing import Any

from service.errors import NotFinished
from service.executions.position import last_status
from service.jobs.job import JobSummary
from service.scene_jobs import SceneJobs


async def executed_motions(desk: SceneJobs, scene: str, most: int) -> list[dict[str, Any]]:
    """Return what tasks need to replay the last motions of a scene, oldest first.

    Each is shown in the revision that it was carried out in, and as far as it went.

    Raises:
        NotFinished: Nothing has moved in the scene yet.
    """
    found: list[dict[str, Any]] = []
    async for job in desk.newest("execution", scene=scene):
        if len(found) == most:
            break
        status = await last_status(desk, job)
        if job.finished_at is not None and status is not None:
            found.append(await _motion(desk, job, status))
    if not found:
        message = f"no execution has moved anything in scene {scene} and ended: nothing to replay"
        raise NotFinished(message, {"id": scene, "state": "unmoved"})
    return found[::-1]


async def _motion(desk: SceneJobs, brief: JobSummary, status: dict[str, Any]) -> dict[str, Any]:
    job = await desk.job("execution", brief.id)  # briefs have no trajectory
    payload = {part: job.payload[part] for part in ("library", "scene", "group", "trajectory")}
    is_whole = job.state == "succeeded"
    title = job.payload["request"].get("title") or f"{job.payload['group']} moves"
    return {
        **payload,
        "title": title if is_whole else f"{title} ({job.state})",
        "until": None if is_whole else status["time"],
    }
