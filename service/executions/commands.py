"""Steering: what is asked of an execution that waits or runs."""

from planning.errors import IllegalTransition
from service.executions.controls import IS_PAUSED, SPEED
from service.jobs.job import Job, JobSummary
from service.jobs.service import JobService


async def steer(
    desk: JobService, job: JobSummary, *, is_paused: bool | None = None, speed: float | None = None
) -> Job:
    """Ask an execution to rest, to move on, or to move at another speed, and return it.

    Raises:
        IllegalTransition: It has ended or is to end.
    """
    if job.state.is_final or job.is_cancel_requested:
        state = job.state if job.state.is_final else "canceling"
        message = f"execution {job.id} is {state}: it cannot be steered any more"
        raise IllegalTransition(message, {"state": state, "event": "steer", "legal": []})
    asked = {IS_PAUSED: is_paused, SPEED: speed}
    return await desk.control(job, {name: item for name, item in asked.items() if item is not None})
