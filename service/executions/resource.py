"""Executions as clients see them, from their jobs."""

from service.api.failures.failure import Failure
from service.executions.models import Execution, ExecutionState, ExecutionStatus
from service.executions.motions.current_motion import followed
from service.executions.position import last_status
from service.executions.tasks import ExecutionOutcome, ExecutionOutline
from service.jobs.job import JobSummary
from service.jobs.service import JobService
from service.jobs.states import JobState

_FINAL = {
    JobState.SUCCEEDED: ExecutionState.SUCCEEDED,
    JobState.FAILED: ExecutionState.ABORTED,
    JobState.CANCELED: ExecutionState.CANCELED,
}
# The state of the job of an execution; one that is canceled before it begins ends at once.
JOB_STATES = {
    ExecutionState.ACCEPTED: JobState.QUEUED,
    ExecutionState.EXECUTING: JobState.RUNNING,
    ExecutionState.PAUSED: JobState.RUNNING,
    ExecutionState.CANCELING: JobState.RUNNING,
    ExecutionState.ABORTING: JobState.RUNNING,
    ExecutionState.SUCCEEDED: JobState.SUCCEEDED,
    ExecutionState.CANCELED: JobState.CANCELED,
    ExecutionState.ABORTED: JobState.FAILED,
}


async def execution_resource(jobs: JobService, job: JobSummary) -> Execution:
    """Return an execution in full."""
    job = jobs.with_cancel(job)
    work = ExecutionOutline.model_validate(job.payload)
    status = await last_status(jobs, job)
    state = state_of(job, status)
    outcome = None if job.result is None else ExecutionOutcome.model_validate(job.result)
    failure = None if job.failure is None else Failure.model_validate(job.failure)
    ended = outcome or failure
    return Execution(
        id=job.id,
        state=state,
        created_at=job.created_at,
        started_at=job.started_at,
        finished_at=job.finished_at,
        cancel_requested_at=job.cancel_requested_at,
        attempts=job.attempts,
        request=work.request,
        scene=work.scene_id,
        group=work.group,
        delays=work.delays,
        is_waiting=work.is_waiting and job.state is JobState.QUEUED,
        status=None if status is None else status.model_copy(update={"state": state}),
        replanned=work.replanned,
        motions=await followed(jobs, job),
        failure=failure,
        timings={} if ended is None else ended.timings,
        sampling=None if outcome is None else outcome.sampling,
        unrecorded=jobs.unrecorded(job),
    )


def state_of(job: JobSummary, status: ExecutionStatus | None) -> ExecutionState:
    """Return the job's state where that is final, else the state of the latest status."""
    if job.state in _FINAL:
        return _FINAL[job.state]
    if job.is_cancel_requested:
        return ExecutionState.CANCELING
    if job.state is JobState.QUEUED:
        return ExecutionState.ACCEPTED
    if status is None or status.state in _FINAL.values():
        return ExecutionState.EXECUTING
    return status.state
