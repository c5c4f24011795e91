"""/v1/executions: carry out plans, watch them, stop them."""

# ruff: noqa: FAST003  (the dependencies take the path parameters)

from collections.abc import AsyncIterator
from typing import Annotated, Any

from fastapi import APIRouter, Query
from fastapi.sse import EventSourceResponse, ServerSentEvent

from service.api.event_stream import EVENTS, server_sent
from service.api.params import Cursor, LastEventId, Limit
from service.api.responses import accepted, problems
from service.api.strict_route import StrictRoute
from service.api.submission import SubmissionDep
from service.dependencies import ExecutionJob, JobsDep, OpenExecution, ScenesDep
from service.executions.commands import steer
from service.executions.models import (
    Execution,
    ExecutionPage,
    ExecutionRequest,
    SpeedRequest,
)
from service.executions.resource import execution_resource
from service.executions.submit import submit_execution

router = APIRouter(route_class=StrictRoute, prefix="/v1/executions", tags=["executions"])
type OfScene = Annotated[str | None, Query(max_length=128, description="Only those in this scene")]


@router.post(
    "",
    operation_id="createExecution",
    status_code=202,
    response_model=Execution,
    responses=accepted(Execution, "the execution", 400, 404, 409, 413, 422, 429, 503),
)
async def create_execution(
    request: ExecutionRequest, asked: SubmissionDep, scenes: ScenesDep
) -> Any:
    """Carry out a plan, if its start is where the robot is."""
    job = await submit_execution(request, asked.key, scenes, asked.desk)
    found = await asked.awaited(job, "/v1/executions")
    return await execution_resource(asked.desk, found.summary)


@router.get(
    "", operation_id="listExecutions", response_model=ExecutionPage, responses=problems(422)
)
async def list_executions(
    desk: JobsDep, scene: OfScene = None, limit: Limit = 50, cursor: Cursor = None
) -> Any:
    """List executions, newest first."""
    page = await desk.page("execution", limit, cursor, scene=scene)
    items = [await execution_resource(desk, job) for job in page.jobs]
    return {"items": items, "next": page.following}


@router.get(
    "/{execution}",
    operation_id="getExecution",
    response_model=Execution,
    responses=problems(404, 422),
)
async def get_execution(job: ExecutionJob, desk: JobsDep) -> Any:
    """Show an execution: its state, progress, measured positions, tracking error, contacts."""
    return await execution_resource(desk, job)


@router.get(
    "/{execution}/events",
    operation_id="streamExecutionEvents",
    response_class=EventSourceResponse,
    responses={200: EVENTS, **problems(404, 422)},
)
async def stream_execution_events(
    job: ExecutionJob, desk: JobsDep, last_event_id: LastEventId = None
) -> AsyncIterator[ServerSentEvent]:
    """Stream what happens to an execution: queued, started, status, finished."""
    async for event in server_sent(desk, job, last_event_id):
        yield event


@router.post(
    "/{execution}/cancel",
    operation_id="cancelExecution",
    response_model=Execution,
    responses=problems(404, 422),
)
async def cancel_execution(job: OpenExecution, desk: JobsDep) -> Any:
    """Bring the robot to rest on its path and end; asking again changes nothing.

    The robot is told first, and no database is waited for: `unrecorded` says what it does not hold
    yet. So for a pause, and for a change of speed.
    """
    return await execution_resource(desk, await desk.cancel(job))


@router.post(
    "/{execution}/pause",
    operation_id="pauseExecution",
    response_model=Execution,
    responses=problems(404, 409, 422),
)
async def pause_execution(job: OpenExecution, desk: JobsDep) -> Any:
    """Bring the robot to rest on its path, until it is resumed."""
    return await execution_resource(desk, await steer(desk, job, is_paused=True))


@router.post(
    "/{execution}/resume",
    operation_id="resumeExecution",
    response_model=Execution,
    responses=problems(404, 409, 422),
)
async def resume_execution(job: OpenExecution, desk: JobsDep) -> Any:
    """Move on after a pause."""
    return await execution_resource(desk, await steer(desk, job, is_paused=False))


@router.post(
    "/{execution}/speed",
    operation_id="setExecutionSpeed",
    response_model=Execution,
    responses=problems(400, 404, 409, 413, 422),
)
async def set_execution_speed(job: OpenExecution, desk: JobsDep, request: SpeedRequest) -> Any:
    """Change how fast the motion is carried out; the robot gets there along its path."""
    return await execution_resource(desk, await steer(desk, job, speed=request.speed))
