"""/v1/scenes/{id}/regions and /v1/regions: grow regions, poll them, stop them."""

# ruff: noqa: FAST003  (the dependencies take the path parameters)

from collections.abc import AsyncIterator
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from service.api.dependencies import JobsDep
from service.api.event_stream import EVENTS, server_sent
from service.api.paging import Cursor, Limit, before, cursor_of
from service.api.params import LastEventId, RegionsId, SceneId
from service.api.responses import accepted, problems
from service.api.routing.strict_route import StrictRoute
from service.api.submission import SubmissionDep
from service.jobs.job import JobSummary, JobText
from service.jobs.states import JobState
from service.regions.models import RegionsJob, RegionsPage, RegionsRequest
from service.regions.resource import regions_brief, regions_in_full
from service.regions.submit import submit_regions
from service.scenes.dependencies import ScenesDep

router = APIRouter(route_class=StrictRoute, prefix="/v1", tags=["regions"])


async def _regions_text(regions: RegionsId, jobs: JobsDep) -> JobText:
    return await jobs.job_text("regions", regions)


async def _open_regions(regions: RegionsId, jobs: JobsDep) -> JobSummary:
    return await jobs.open_job("regions", regions)


# With its result, which is passed on as it is.
type RegionsText = Annotated[JobText, Depends(_regions_text)]
# As memory has it while it waits or runs: what is to be stopped waits for no database.
type OpenRegions = Annotated[JobSummary, Depends(_open_regions)]

type State = Annotated[JobState | None, Query(description="Only those in this state")]


@router.post(
    "/scenes/{scene}/regions",
    operation_id="growRegions",
    status_code=202,
    response_model=RegionsJob,
    responses=accepted(RegionsJob, "the regions", 400, 404, 409, 413, 422, 429, 503),
)
async def grow_regions(
    scene: SceneId, request: RegionsRequest, asked: SubmissionDep, scenes: ScenesDep
) -> Response:
    """Grow convex regions of free configurations, for plans with the planner GCS."""
    job = await submit_regions(scene, request, asked.key, scenes, asked.jobs)
    return await regions_in_full(
        asked.jobs, await asked.awaited(job, "/v1/regions"), asked.response
    )


@router.get(
    "/scenes/{scene}/regions",
    operation_id="listRegions",
    responses=problems(404, 422),
)
async def list_regions(
    scene: SceneId,
    jobs: JobsDep,
    scenes: ScenesDep,
    state: State = None,
    limit: Limit = 50,
    cursor: Cursor = None,
) -> RegionsPage:
    """List the regions that were asked for in a scene, newest first, without their faces."""
    record = await scenes.get(scene)
    page = await jobs.page("regions", limit, before(cursor), state=state, scene=record.id)
    items = [regions_brief(jobs, job) for job in page.jobs]
    return RegionsPage(items=items, next=cursor_of(page.following))


@router.get(
    "/regions/{regions}",
    operation_id="getRegions",
    response_model=RegionsJob,
    responses=problems(404, 422),
)
async def get_regions(found: RegionsText, jobs: JobsDep) -> Response:
    """Show regions: how far they are, and all of them once they have grown."""
    return await regions_in_full(jobs, found)


@router.delete(
    "/regions/{regions}",
    operation_id="deleteRegions",
    status_code=204,
    response_class=Response,  # which has no content type
    responses=problems(404, 409, 422),
)
async def delete_regions(job: OpenRegions, jobs: JobsDep) -> None:
    """Delete regions that have ended; plans that were made in them stay."""
    await jobs.delete(job)


@router.get(
    "/regions/{regions}/events",
    operation_id="streamRegionsEvents",
    response_class=EventSourceResponse,
    responses={200: EVENTS, **problems(404, 422)},
)
async def stream_regions_events(
    job: OpenRegions, jobs: JobsDep, last_event_id: LastEventId = None
) -> AsyncIterator[ServerSentEvent]:
    """Stream what happens to regions: queued, started, stage, progress, finished."""
    async for event in server_sent(jobs, job, last_event_id):
        yield event


@router.post(
    "/regions/{regions}/cancel",
    operation_id="cancelRegions",
    response_model=RegionsJob,
    responses=problems(404, 422),
)
async def cancel_regions(job: OpenRegions, jobs: JobsDep) -> Response:
    """End the growth, in whatever state it is; asking again changes nothing."""
    return await regions_in_full(jobs, await jobs.text_of(await jobs.cancel(job)))
