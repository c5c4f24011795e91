"""Straight lines in a loaded scene."""

import time
from typing import Any

import numpy as np

from planning import Deadline, trace_line
from service.jobs.context import TaskContext
from service.plans.models.goal_values import line_end_value
from service.queries.line_conversion import fineness_value, trace_wire
from service.queries.models.line import LineRequest
from service.scenes.tasks import SceneWork
from service.scenes.world_cache import borrow_world


def line(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return how far a tool can be moved in a straight line, and what stops it.

    Raises:
        InputError: The group, a frame or a count is wrong.
        PlanningFailure: Time ran out.
    """
    request = LineRequest.model_validate(payload["request"])
    start = None if request.start is None else np.array(request.start, dtype=np.float64)
    deadline = Deadline.after(request.allowed_time, time.monotonic, channel.is_canceled)
    with borrow_world(SceneWork.model_validate(payload)) as world:
        trace = trace_line(
            world,
            request.group,
            line_end_value(request),
            deadline=deadline,
            start=start,
            frame=request.frame or "",
            margin=request.margin,
            fineness=fineness_value(request),
        )
    return trace_wire(trace, with_poses=request.poses)
