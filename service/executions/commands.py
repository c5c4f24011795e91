"""Commands to an execution that waits or runs."""

from planning.errors import IllegalTransition
from service.executions.tasks import Commands
from service.jobs.job import Job, JobSummary
from service.jobs.service import JobService


async def send_command(jobs: JobService, job: JobSummary, commands: Commands) -> Job:
    """Have an execution rest, move on, or move at another speed, and return it.

    Args:
        jobs: Knows the job.
        job: Of the execution.
        commands: Of which those that are set are sent.

    Raises:
        IllegalTransition: It has ended or is to end.
    """
    if job.state.is_final or job.is_cancel_requested:
        state = job.state if job.state.is_final else "canceling"
        message = f"execution {job.id} is {state}: it cannot be steered any more"
        raise IllegalTransition(message, {"state": state, "event": "steer", "legal": []})
    return await jobs.control(job, commands.model_dump(exclude_unset=True))
