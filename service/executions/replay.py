"""/v1/scenes/{id}/replay.html: the motions that executions carried out in a scene, in order."""

from typing import Annotated

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse

from service.api.dependencies import JobsDep
from service.api.params import SceneId
from service.api.responses import HTML_PAGE, problems
from service.api.routing.strict_route import StrictRoute
from service.errors import NotFinished
from service.executions.models import ExecutionStatus, FollowedMotion
from service.executions.position import last_status
from service.executions.tasks import MOTION, REPLAY_MOTIONS, ExecutionWork, ReplayWork, ShownWork
from service.jobs.job import JobSummary
from service.jobs.service import JobService
from service.plans.models.trajectory import Polynomial
from service.scenes.dependencies import ScenesDep

router = APIRouter(
    route_class=StrictRoute, prefix="/v1/scenes/{scene}/replay.html", tags=["scenes"]
)

# Each may need a world of its own in memory.
_MOST_MOTIONS = 32

type LastMotions = Annotated[
    int, Query(ge=1, le=_MOST_MOTIONS, description="Number of motions, counted from the last one")
]


@router.get(
    "",
    operation_id="getSceneReplay",
    response_class=HTMLResponse,
    responses={200: HTML_PAGE, **problems(404, 409, 422, 429, 503)},
)
async def get_scene_replay(
    scene: SceneId, scenes: ScenesDep, jobs: JobsDep, last: LastMotions = _MOST_MOTIONS
) -> HTMLResponse:
    """Replay in 3-D what executions moved in a scene, one motion after the other."""
    record = await scenes.stored(scene)
    motions = await executed_motions(jobs, record.id, last)
    page = await jobs.call(REPLAY_MOTIONS, ReplayWork(motions=motions))
    return HTMLResponse(page.html)


async def executed_motions(jobs: JobService, scene: str, most: int) -> list[ShownWork]:
    """Return the last motions that were carried out in a scene, oldest first.

    Each is shown in the revision that it was carried out in, and as far as it went.

    Raises:
        NotFinished: Nothing has moved in the scene yet.
    """
    found: list[ShownWork] = []
    async for job in jobs.newest("execution", scene=scene):
        if len(found) >= most:
            break
        status = await last_status(jobs, job)
        if job.finished_at is not None and status is not None:
            found += (await _motions(jobs, job, status))[::-1]
    if not found:
        message = f"no execution has moved anything in scene {scene} and ended: nothing to replay"
        raise NotFinished(message, {"id": scene, "state": "unmoved"})
    return found[:most][::-1]


async def _motions(
    jobs: JobService, summary: JobSummary, status: ExecutionStatus
) -> list[ShownWork]:
    """Return the motions of one execution: several, if it began anew on the way."""
    job = await jobs.job("execution", summary.id)  # lists have no trajectory
    work = ExecutionWork.model_validate(job.payload)
    is_whole = job.state == "succeeded"
    title = work.request.title or f"{work.group} moves"
    shown = [(work.trajectory, status.time)]
    async for event in jobs.events(summary, 0):
        if event.type == MOTION:
            last = FollowedMotion.model_validate(event.data["motions"][-1])
            # what is spliced has what was passed of the motion before it
            kept = [] if last.is_spliced else [(shown[-1][0], last.left_at)]
            following = Polynomial.model_validate(event.data["trajectory"])
            shown = [*shown[:-1], *kept, (following, status.time)]
    return [
        ShownWork(
            library=work.library,
            scene=work.scene,
            group=work.group,
            trajectory=trajectory,
            title=title if is_whole else f"{title} ({job.state})",
            until=None if is_whole and trajectory is shown[-1][0] else until,
        )
        for trajectory, until in shown
    ]
