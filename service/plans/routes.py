"""/v1/plans: request plans, poll them, stop them."""

# ruff: noqa: FAST003  (the dependencies take the path parameters)

from collections.abc import AsyncIterator, Collection
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from service.api.dependencies import JobsDep
from service.api.event_stream import EVENTS, server_sent
from service.api.paging import Cursor, Limit, OfScene, before, cursor_of
from service.api.params import LastEventId
from service.api.responses import accepted, problems, whole
from service.api.routing.straight_route import StraightRoute
from service.api.submission import KeyHeader, Prefer, SubmissionDep, Wait, submission_of
from service.jobs.job import JobText
from service.jobs.service import JobService
from service.jobs.states import JobState
from service.plans.dependencies import OpenPlan, PlanJob, PlanText
from service.plans.included_parts import Include, LeftOut, left_out_of
from service.plans.models.plan import Plan, PlanPage
from service.plans.models.request import PlanRequest
from service.plans.models.search_reports import PlannerGraph
from service.plans.resource import graph_of, plan_resource
from service.plans.submit import submit_plan, submit_reversed
from service.scenes.dependencies import ScenesDep, scenes_of

router = APIRouter(route_class=StraightRoute, prefix="/v1/plans", tags=["plans"])
type OfBatch = Annotated[str | None, Query(max_length=128, description="Only those of this batch")]
type State = Annotated[JobState | None, Query(description="Only those in this state")]


@router.post(
    "",
    operation_id="createPlan",
    status_code=202,
    response_model=Plan,
    responses=accepted(Plan, "the plan", 400, 404, 409, 413, 422, 429, 503),
)
async def create_plan(  # noqa: PLR0913  (all that a request says)
    request: PlanRequest,
    http: Request,
    response: Response,
    *,
    wait: Wait = None,
    prefer: Prefer = None,
    idempotency_key: KeyHeader = None,
    include: Include = None,
) -> Response:
    """Request a plan: a job that is polled, streamed or waited for."""
    # FastAPI takes as long for a dependency as for all these parameters, and plans are waited for.
    submission = submission_of(http, response, wait, prefer, idempotency_key)
    left_out = left_out_of(include)
    job = await submit_plan(request, submission, scenes_of(http))
    # While the plan is made, not when it is there.
    settled = PlanRequest.model_validate(job.payload["request"])
    known = {"request": settled.model_dump_json()}
    found = await submission.awaited(job, "/v1/plans")
    brief = await plan_resource(submission.jobs, found.summary, settled)
    return await whole(brief, found.result, submission.response, left_out, known)


@router.get("", operation_id="listPlans", responses=problems(422))
async def list_plans(
    jobs: JobsDep,
    state: State = None,
    scene: OfScene = None,
    batch: OfBatch = None,
    limit: Limit = 50,
    cursor: Cursor = None,
) -> PlanPage:
    """List plans, newest first, without their results."""
    page = await jobs.page("plan", limit, before(cursor), state=state, scene=scene, batch=batch)
    plans = [await plan_resource(jobs, job) for job in page.jobs]
    return PlanPage(items=plans, next=cursor_of(page.following))


@router.get("/{plan}", operation_id="getPlan", response_model=Plan, responses=problems(404, 422))
async def get_plan(found: PlanText, jobs: JobsDep, left_out: LeftOut) -> Response:
    """Show a plan: how far it is, and its result once it succeeded."""
    return await _whole(jobs, found, left_out=left_out)


@router.delete(
    "/{plan}",
    operation_id="deletePlan",
    status_code=204,
    response_class=Response,  # which has no content type
    responses=problems(404, 409, 422),
)
async def delete_plan(job: OpenPlan, jobs: JobsDep) -> None:
    """Delete a plan that has ended; its address is unknown then, and its idempotency key free.

    Executions and reversed plans that were made of it stay, for they have its motion themselves.
    """
    await jobs.delete(job)


@router.get(
    "/{plan}/events",
    operation_id="streamPlanEvents",
    response_class=EventSourceResponse,
    responses={200: EVENTS, **problems(404, 422)},
)
async def stream_plan_events(
    job: OpenPlan, jobs: JobsDep, last_event_id: LastEventId = None
) -> AsyncIterator[ServerSentEvent]:
    """Stream what happens to a plan: queued, started, stage, progress, best-so-far, finished."""
    async for event in server_sent(jobs, job, last_event_id):
        yield event


@router.get(
    "/{plan}/graph",
    operation_id="getPlannerGraph",
    responses=problems(404, 409, 422),
)
async def get_planner_graph(job: PlanJob) -> PlannerGraph:
    """Show what the planner explored, if `search.keep_graph` of the request had it kept."""
    return graph_of(job)


@router.post(
    "/{plan}/reverse",
    operation_id="reversePlan",
    status_code=202,
    response_model=Plan,
    responses=accepted(Plan, "the plan", 404, 409, 422, 429, 503),
)
async def reverse_plan(
    job: PlanJob, submission: SubmissionDep, scenes: ScenesDep, left_out: LeftOut
) -> Response:
    """Request the same motion from its end to its start: a plan of its own, proven anew."""
    reverse = await submit_reversed(job, submission.key, scenes, submission.jobs)
    found = await submission.awaited(reverse, "/v1/plans")
    return await _whole(submission.jobs, found, submission.response, left_out)


@router.post(
    "/{plan}/cancel", operation_id="cancelPlan", response_model=Plan, responses=problems(404, 422)
)
async def cancel_plan(job: OpenPlan, jobs: JobsDep) -> Response:
    """End a plan, in whatever state it is; asking again changes nothing.

    No database is waited for: `unrecorded` says what it does not hold yet.
    """
    return await _whole(jobs, await jobs.text_of(await jobs.cancel(job)))


async def _whole(
    jobs: JobService,
    found: JobText,
    answer: Response | None = None,
    left_out: Collection[str] = (),
) -> Response:
    """Return a plan in full, or without some parts of its result."""
    return await whole(await plan_resource(jobs, found.summary), found.result, answer, left_out)
