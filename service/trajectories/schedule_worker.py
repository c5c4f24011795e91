"""Schedules of the motions of several plans."""

import time

from planning import Deadline, GroupMotion, RetimeOptions, schedule_motions
from planning.errors import PlanningFailure
from service.api.failures.failure import Failure
from service.jobs.context import TaskContext
from service.scenes.world_cache import borrow_world
from service.trajectories.schedule_models import MotionSchedule, ScheduleMotionsResponse
from service.trajectories.tasks import SCHEDULE, ScheduleWork


@SCHEDULE.runs
def schedule(work: ScheduleWork, context: TaskContext) -> ScheduleMotionsResponse:
    """Return when each motion begins, or why there is no schedule.

    Raises:
        InputError: The motions do not fit the scene, or two of them move one joint.
    """
    request = work.request
    motions = [GroupMotion(one.group, one.trajectory.to_domain()) for one in work.motions]
    with borrow_world(work) as world:
        try:
            found = schedule_motions(
                world,
                motions,
                deadline=Deadline.after(request.allowed_time, time.monotonic, context.is_canceled),
                options=RetimeOptions(method="ruckig" if request.limit_jerk else "toppra"),
                margin=request.margin,
            )
        except PlanningFailure as failure:
            why = Failure.from_error(failure)
            return ScheduleMotionsResponse(schedule=None, failure=why)
    return ScheduleMotionsResponse(
        schedule=MotionSchedule.from_domain(found, polynomial=request.polynomial), failure=None
    )
