"""What a request about a motion demands of it, as the functions of planning take it."""

import time
from typing import Literal, TypedDict

from planning import Deadline, RetimeOptions
from planning.domain.request.constraint import PathConstraint
from service.jobs.context import TaskContext
from service.plans.models.constraints import constraints_to_domain
from service.plans.models.motion_limits import ScaledLimits
from service.trajectories.models import MotionRequest


class MotionDemands(TypedDict):
    """What a motion must keep."""

    options: RetimeOptions
    constraints: tuple[PathConstraint, ...]
    margin: float | None


def demands_of(request: MotionRequest, options: RetimeOptions) -> MotionDemands:
    """Return what a motion must keep, under limits."""
    constraints = constraints_to_domain(request.path_constraints)
    return MotionDemands(options=options, constraints=constraints, margin=request.margin)


def options_of(limits: ScaledLimits, *, limit_jerk: bool) -> RetimeOptions:
    """Return the limits that a motion must keep."""
    method: Literal["ruckig", "toppra"] = "ruckig" if limit_jerk else "toppra"
    return RetimeOptions(method=method, **limits.limit_fields())


def deadline_of(request: MotionRequest, context: TaskContext) -> Deadline:
    """Return by when a task about a motion is to end."""
    return Deadline.after(request.allowed_time, time.monotonic, context.is_canceled)
