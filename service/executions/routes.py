"""/v1/executions: carry out motions, watch them, steer them, stop them."""

# ruff: noqa: FAST003  (the dependencies take the path parameters)

from collections.abc import AsyncIterator
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from service.api.dependencies import JobsDep, SettingsDep
from service.api.event_stream import EVENTS, server_sent
from service.api.paging import Cursor, Limit, OfScene, before, cursor_of
from service.api.params import ExecutionId, LastEventId
from service.api.responses import accepted, problems
from service.api.routing.strict_route import StrictRoute
from service.api.submission import SubmissionDep
from service.executions.commands import send_command
from service.executions.drivers.controllers import check_speed
from service.executions.models import (
    Execution,
    ExecutionEvent,
    ExecutionPage,
    ExecutionState,
)
from service.executions.replanning.new_plan import Terms
from service.executions.requests import ExecutionRequest, SpeedRequest
from service.executions.resource import JOB_STATES, execution_resource
from service.executions.submit import submit_execution
from service.executions.tasks import Commands
from service.jobs.job import Job, JobSummary
from service.scenes.dependencies import ScenesDep

router = APIRouter(route_class=StrictRoute, prefix="/v1/executions", tags=["executions"])


async def _execution_job(execution: ExecutionId, jobs: JobsDep) -> Job:
    return await jobs.job("execution", execution)


async def _open_execution(execution: ExecutionId, jobs: JobsDep) -> JobSummary:
    return await jobs.open_job("execution", execution)


type ExecutionJob = Annotated[Job, Depends(_execution_job)]
# As memory has it while it waits or runs: what is to be stopped waits for no database.
type OpenExecution = Annotated[JobSummary, Depends(_open_execution)]

type State = Annotated[ExecutionState | None, Query(description="Only those in this state")]


@router.post(
    "",
    operation_id="createExecution",
    status_code=202,
    responses=accepted(Execution, "the execution", 400, 404, 409, 413, 422, 429, 503),
)
async def create_execution(
    request: ExecutionRequest, asked: SubmissionDep, scenes: ScenesDep, settings: SettingsDep
) -> Execution:
    """Carry out a motion that starts where its robots are and is proven, beside all that moves.

    It is of a plan, of several plans as one, or your own.
    """
    job = await submit_execution(request, asked.key, scenes, Terms(asked.jobs, settings))
    found = await asked.awaited(job, "/v1/executions")
    return await execution_resource(asked.jobs, found.summary)


@router.get("", operation_id="listExecutions", responses=problems(422))
async def list_executions(
    jobs: JobsDep,
    state: State = None,
    scene: OfScene = None,
    limit: Limit = 50,
    cursor: Cursor = None,
) -> ExecutionPage:
    """List executions, newest first; a page in a state before the last may have fewer of them."""
    of_jobs = None if state is None else JOB_STATES[state]
    page = await jobs.page("execution", limit, before(cursor), state=of_jobs, scene=scene)
    items = [await execution_resource(jobs, job) for job in page.jobs]
    kept = [item for item in items if state in {None, item.state}]
    return ExecutionPage(items=kept, next=cursor_of(page.following))


@router.get(
    "/{execution}",
    operation_id="getExecution",
    responses=problems(404, 422),
)
async def get_execution(job: ExecutionJob, jobs: JobsDep) -> Execution:
    """Show an execution: its state, progress, measured positions, tracking error, contacts."""
    return await execution_resource(jobs, job)


@router.delete(
    "/{execution}",
    operation_id="deleteExecution",
    status_code=204,
    response_class=Response,  # which has no content type
    responses=problems(404, 409, 422),
)
async def delete_execution(job: OpenExecution, jobs: JobsDep) -> None:
    """Delete an execution that has ended; the scene keeps its robot where it was left."""
    await jobs.delete(job)


@router.get(
    "/{execution}/events",
    operation_id="streamExecutionEvents",
    response_class=EventSourceResponse,
    responses={200: {**EVENTS, "model": ExecutionEvent}, **problems(404, 422)},
)
async def stream_execution_events(
    job: ExecutionJob, jobs: JobsDep, last_event_id: LastEventId = None
) -> AsyncIterator[ServerSentEvent]:
    """Stream what happens to an execution: queued, started, stage, status, finished."""
    async for event in server_sent(jobs, job, last_event_id):
        yield event


@router.post(
    "/{execution}/cancel",
    operation_id="cancelExecution",
    responses=problems(404, 422),
)
async def cancel_execution(job: OpenExecution, jobs: JobsDep) -> Execution:
    """Bring the robot to rest on its path and end; asking again changes nothing.

    As for a pause and a change of speed, the robot is told first, and no database is waited for:
    `unrecorded` says what it does not hold yet.
    """
    return await execution_resource(jobs, await jobs.cancel(job))


@router.post(
    "/{execution}/pause",
    operation_id="pauseExecution",
    responses=problems(404, 409, 422),
)
async def pause_execution(job: OpenExecution, jobs: JobsDep) -> Execution:
    """Bring the robot to rest on its path, until it is resumed."""
    return await execution_resource(jobs, await send_command(jobs, job, Commands(is_paused=True)))


@router.post(
    "/{execution}/resume",
    operation_id="resumeExecution",
    responses=problems(404, 409, 422),
)
async def resume_execution(job: OpenExecution, jobs: JobsDep) -> Execution:
    """Move on after a pause."""
    return await execution_resource(jobs, await send_command(jobs, job, Commands(is_paused=False)))


@router.post(
    "/{execution}/speed",
    operation_id="setExecutionSpeed",
    responses=problems(400, 404, 409, 413, 422),
)
async def set_execution_speed(
    job: OpenExecution, jobs: JobsDep, request: SpeedRequest
) -> Execution:
    """Change how fast and which way the motion is carried out; the robot stays on its path.

    With 0 it rests and is still `executing`; back at the beginning of its path it rests and waits.
    """
    check_speed(job, request.speed)
    return await execution_resource(
        jobs, await send_command(jobs, job, Commands(speed=request.speed))
    )
