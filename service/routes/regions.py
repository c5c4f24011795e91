"""/v1/scenes/{id}/regions and /v1/regions: grow regions, poll them, stop them."""

# ruff: noqa: FAST003  (the dependencies take the path parameters)

from collections.abc import AsyncIterator
from typing import Any

from fastapi import APIRouter, Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from service.dependencies import JobsDep, OpenRegions, RegionsText, ScenesDep
from service.jobs.job import JobText
from service.regions.admission import submit_regions
from service.regions.wire import regions_brief
from service.routes.answers import Cursor, LastEventId, Limit, SceneId, problems
from service.routes.streaming import EVENTS, server_sent
from service.routes.submission import SubmissionDep, taken_in
from service.routes.whole import whole
from service.scene_jobs import SceneJobs
from service.schemas.regions import RegionsBrief, RegionsJob, RegionsPage, RegionsRequest
from service.strict_route import StrictRoute

router = APIRouter(route_class=StrictRoute, prefix="/v1", tags=["regions"])


@router.post(
    "/scenes/{scene}/regions",
    operation_id="growRegions",
    status_code=202,
    response_model=RegionsJob,
    responses=taken_in(RegionsJob, "the regions", 400, 404, 409, 413, 422, 429, 503),
)
async def grow_regions(
    scene: SceneId, request: RegionsRequest, asked: SubmissionDep, scenes: ScenesDep
) -> Any:
    """Grow convex regions of free configurations, for plans with the planner GCS."""
    job = await submit_regions(scene, request, asked.key, scenes, asked.desk)
    return await _whole(asked.desk, await asked.awaited(job, "/v1/regions"), asked.response)


@router.get(
    "/scenes/{scene}/regions",
    operation_id="listRegions",
    response_model=RegionsPage,
    responses=problems(404, 422),
)
async def list_regions(
    scene: SceneId,
    desk: JobsDep,
    scenes: ScenesDep,
    limit: Limit = 50,
    cursor: Cursor = None,
) -> Any:
    """List the regions that were asked for in a scene, newest first, without their faces."""
    record = await scenes.get(scene)
    page = await desk.page("regions", limit, cursor, scene=record.id)
    return {"items": [regions_brief(desk, job) for job in page.jobs], "next": page.following}


@router.get(
    "/regions/{regions}",
    operation_id="getRegions",
    response_model=RegionsJob,
    responses=problems(404, 422),
)
async def get_regions(found: RegionsText, desk: JobsDep) -> Any:
    """Show regions: how far they are, and all of them once they have grown."""
    return await _whole(desk, found)


@router.get(
    "/regions/{regions}/events",
    operation_id="streamRegionsEvents",
    response_class=EventSourceResponse,
    responses={200: EVENTS, **problems(404, 422)},
)
async def stream_regions_events(
    job: OpenRegions, desk: JobsDep, last_event_id: LastEventId = None
) -> AsyncIterator[ServerSentEvent]:
    """Stream what happens to regions: queued, started, stage, progress, finished."""
    async for event in server_sent(desk, job, last_event_id):
        yield event


@router.post(
    "/regions/{regions}/cancel",
    operation_id="cancelRegions",
    response_model=RegionsJob,
    responses=problems(404, 422),
)
async def cancel_regions(job: OpenRegions, desk: JobsDep) -> Any:
    """End the growth, in whatever state it is; asking again changes nothing."""
    return await _whole(desk, await desk.text_of(await desk.cancel(job)))


async def _whole(desk: SceneJobs, found: JobText, told: Response | None = None) -> Response:
    """Return regions in full."""
    brief = RegionsBrief.model_validate(regions_brief(desk, found.summary))
    return await whole(brief, found.result, told)
