"""/v1/plans/batch and /v1/batches: plans asked for in one request, polled and ended together."""

# ruff: noqa: FAST003  (the dependencies take the path parameters)

from collections.abc import AsyncIterator, Sequence
from typing import Annotated

from fastapi import APIRouter, Depends, Header, Path, Query, Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from service.api.dependencies import JobsDep
from service.api.event_stream import EVENTS
from service.api.paging import Cursor, Limit, before, cursor_of
from service.api.responses import accepted, problems
from service.api.routing.strict_route import StrictRoute
from service.api.submission import SubmissionDep
from service.jobs.job import BatchMember
from service.jobs.states import JobState
from service.plans.batch_events import batch_events
from service.plans.batches import batch_resource, cancel_batch, members_of, submit_batch
from service.plans.models.batch import Batch, BatchPage, BatchRequest, BatchSummary
from service.scenes.dependencies import ScenesDep

router = APIRouter(route_class=StrictRoute, prefix="/v1", tags=["batches"])

type BatchId = Annotated[str, Path(max_length=128, description="Id of a batch")]
type WithPlanInState = Annotated[
    JobState | None, Query(description="Only those with a plan in this state")
]
type WithPlanInScene = Annotated[
    str | None,
    Query(
        max_length=128,
        description="Only those with a plan in this scene; with `state`, one that is in both",
    ),
]
type LastBatchEventId = Annotated[
    str | None,
    Header(
        alias="Last-Event-ID",
        max_length=4000,
        description="Id of the last event that was seen; those after it are sent",
    ),
]


async def _members(batch: BatchId, jobs: JobsDep) -> Sequence[BatchMember]:
    return await members_of(jobs, batch)


type Members = Annotated[Sequence[BatchMember], Depends(_members)]


@router.post(
    "/plans/batch",
    operation_id="createBatch",
    status_code=202,
    responses=accepted(Batch, "the batch", 400, 404, 409, 413, 422, 429, 503),
)
async def create_batch(
    request: BatchRequest, submission: SubmissionDep, scenes: ScenesDep
) -> Batch:
    """Request plans for up to 256 problems: all of them are queued, or none.

    Each is a plan like any other. An error says in `errors` which problem it is about.
    """
    batch = await submit_batch(request, submission, scenes)
    members = await members_of(submission.jobs, batch)
    await submission.all_awaited([member.id for member in members], f"/v1/batches/{batch}")
    return batch_resource(batch, await members_of(submission.jobs, batch))


@router.get("/batches", operation_id="listBatches", responses=problems(422))
async def list_batches(
    jobs: JobsDep,
    state: WithPlanInState = None,
    scene: WithPlanInScene = None,
    limit: Limit = 50,
    cursor: Cursor = None,
) -> BatchPage:
    """List batches, newest first, without the ids of their plans."""
    page = await jobs.batches("plan", limit, before(cursor), state=state, scene=scene)
    items = [BatchSummary.model_validate(batch) for batch in page.batches]
    return BatchPage(items=items, next=cursor_of(page.following))


@router.get("/batches/{batch}", operation_id="getBatch", responses=problems(404, 422))
async def get_batch(batch: BatchId, members: Members) -> Batch:
    """Show a batch: its plans, and how many of them are in which state."""
    return batch_resource(batch, members)


@router.get(
    "/batches/{batch}/events",
    operation_id="streamBatchEvents",
    response_class=EventSourceResponse,
    responses={200: EVENTS, **problems(404, 422)},
)
async def stream_batch_events(
    members: Members, jobs: JobsDep, last_event_id: LastBatchEventId = None
) -> AsyncIterator[ServerSentEvent]:
    """Stream what happens to all plans of a batch; the data of each event names its `plan`.

    Events of a plan are in order. The stream ends once all plans have.
    """
    async for event in batch_events(jobs, members, last_event_id):
        yield event


@router.post("/batches/{batch}/cancel", operation_id="cancelBatch", responses=problems(404, 422))
async def cancel_batch_of_plans(batch: BatchId, members: Members, jobs: JobsDep) -> Batch:
    """End all plans of a batch that have not ended; asking again changes nothing."""
    await cancel_batch(jobs, members)
    return batch_resource(batch, await members_of(jobs, batch))


@router.delete(
    "/batches/{batch}",
    operation_id="deleteBatch",
    status_code=204,
    response_class=Response,  # which has no content type
    responses=problems(404, 409, 422),
)
async def delete_batch(members: Members, jobs: JobsDep) -> None:
    """Delete all plans of a batch, once all have ended."""
    await jobs.delete(*members)
