"""A plan's motion backwards, as a job."""

import time
from typing import Any

import numpy as np

from planning import Deadline, reverse_plan
from planning.domain.curves.path import JointPath
from planning.domain.report.motion_plan import PlanPart, Progress
from service.jobs.context import TaskContext
from service.plans.models.goal_values import problem_value
from service.plans.models.request import PlanRequest
from service.plans.models.trajectory_conversion import trajectory_value
from service.plans.progress import StageLog
from service.plans.worker import delivered, loaded_in, mind, mind_delivery
from service.scenes.tasks import SceneWork
from service.scenes.world_cache import borrow_world


def reverse_motion(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return what `plan_motion` returns, for the motion backwards.

    Raises:
        WayproofError: It cannot be proven; the error says why.
    """
    request = PlanRequest.model_validate(payload["request"])
    problem = problem_value(PlanRequest.model_validate(payload["origin"]))
    motion = payload["motion"]
    log = StageLog(channel)
    log(Progress("load", 0.0))
    begun = time.monotonic()
    with borrow_world(SceneWork.model_validate(payload)) as world:
        loaded = time.monotonic() - begun
        log(Progress("certify", 0.5, "certifying the motion backwards"))
        allowed = request.search.allowed_planning_time
        mind(channel, allowed)
        deadline = Deadline.after(allowed, time.monotonic, channel.is_canceled)
        with loaded_in(loaded):
            found = reverse_plan(
                world,
                problem,
                JointPath(world.group(problem.group), np.array(motion["path"], dtype=np.float64)),
                trajectory_value(motion["polynomial"]),
                [PlanPart(**part) for part in motion["parts"]],
                deadline,
            )
        log(Progress("samples", 0.97))
        mind_delivery(channel)
        return delivered(found, problem, world, request.retime.sampling, deadline, loaded)
