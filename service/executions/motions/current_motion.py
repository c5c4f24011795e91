"""The motion that an execution follows now: the one that was asked for, or one since."""

from dataclasses import dataclass

from service.executions.models import FollowedMotion
from service.executions.tasks import MOTION, ExecutionWork
from service.jobs.job import JobSummary
from service.jobs.service import JobService
from service.plans.models.trajectory import Polynomial


@dataclass(frozen=True)
class CurrentMotion:
    """A motion that is followed.

    Attributes:
        number: 0 for the one that was asked for.
        trajectory: All of it.
        since: Where on it the robot began to follow it [s].
    """

    number: int
    trajectory: Polynomial
    since: float = 0.0


async def current_motion(jobs: JobService, job: JobSummary, work: ExecutionWork) -> CurrentMotion:
    """Return the motion that an execution follows now."""
    event = await jobs.latest_event(job, MOTION)
    if event is None:
        return CurrentMotion(0, work.trajectory)
    last = FollowedMotion.model_validate(event["motions"][-1])
    since = last.left_at if last.is_spliced else 0.0
    return CurrentMotion(last.number, Polynomial.model_validate(event["trajectory"]), since)


async def followed(jobs: JobService, job: JobSummary) -> list[FollowedMotion]:
    """Return the motions that an execution went on with, in order."""
    event = await jobs.latest_event(job, MOTION)
    return [FollowedMotion.model_validate(each) for each in (event or {}).get("motions", [])]
