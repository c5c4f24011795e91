"""Questions to a loaded scene: validity, forward and inverse kinematics."""

import time
from typing import Any

import numpy as np

from planning import Deadline, check_configurations, forward_kinematics, solve_ik
from planning.api.ik import assess_configurations
from planning.domain.goals.funnel import funnel_evidence
from planning.errors import (
    ApproachBlocked,
    DeadlineExceeded,
    GoalInCollision,
    GoalTooNear,
    GoalUnreachable,
    GoalViolatesConstraint,
    PlanningFailure,
)
from service.jobs.context import TaskContext
from service.plans.models.constraint_values import constraint_values
from service.plans.models.failures import failure_wire
from service.plans.models.goal_values import ik_value, pose_wire, reach_goal_value
from service.queries.models.check import CheckRequest
from service.queries.models.kinematics import FkRequest, IkRequest
from service.queries.solution_conversion import solution_wire
from service.queries.verdict_conversion import verdict_wire
from service.scenes.tasks import SceneWork
from service.scenes.world_cache import borrow_world

_NO_SOLUTION = (
    ApproachBlocked,
    DeadlineExceeded,
    GoalInCollision,
    GoalTooNear,
    GoalUnreachable,
    GoalViolatesConstraint,
)


def check(payload: dict[str, Any], _: TaskContext) -> dict[str, Any]:
    """Return a verdict per configuration.

    Raises:
        InputError: The group or a count is wrong.
    """
    request = CheckRequest.model_validate(payload["request"])
    with borrow_world(SceneWork.model_validate(payload)) as world:
        configurations = np.array(request.configurations, dtype=np.float64)
        verdicts = check_configurations(world, request.group, configurations, request.margin)
    return {"results": [verdict_wire(verdict) for verdict in verdicts]}


def fk(payload: dict[str, Any], _: TaskContext) -> dict[str, Any]:
    """Return the poses of frames per configuration.

    Raises:
        InputError: The group, a frame or a count is wrong.
    """
    request = FkRequest.model_validate(payload["request"])
    with borrow_world(SceneWork.model_validate(payload)) as world:
        frames = tuple(request.frames or world.group(request.group).tool_frames)
        configurations = np.array(request.configurations, dtype=np.float64)
        found = forward_kinematics(world, request.group, configurations, frames)
    return {
        "results": [
            {frame: pose_wire(pose) for frame, pose in by_frame.items()} for by_frame in found
        ]
    }


def ik(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return all goal configurations that were found, or why there is none.

    Raises:
        InputError: The group, a frame or a count is wrong.
        PlanningFailure: The start is invalid, or nobody wants the answer any more.
    """
    request = IkRequest.model_validate(payload["request"])
    start = None if request.start is None else np.array(request.start, dtype=np.float64)
    deadline = Deadline.after(request.allowed_time, time.monotonic, channel.is_canceled)
    goal = reach_goal_value(request.goal)
    with borrow_world(SceneWork.model_validate(payload)) as world:
        try:
            found = solve_ik(
                world,
                request.group,
                goal,
                deadline=deadline,
                start=start,
                options=ik_value(request.ik),
                margin=request.margin,
                constraints=constraint_values(request.path_constraints),
                seed=request.seed,
            )
        except _NO_SOLUTION as failure:
            return _no_configuration(failure)
        qualities = assess_configurations(
            world,
            request.group,
            found.positions,
            start=start,
            frame=goal.frame,
            joint_weights=request.ik.joint_weights,
        )
    solutions = zip(found.positions, found.target_indices, qualities, strict=True)
    return {
        "configurations": [solution_wire(*solution) for solution in solutions],
        "funnel": funnel_evidence(found.funnel),
        "failure": None,
    }


def _no_configuration(failure: PlanningFailure) -> dict[str, Any]:
    funnel = failure.evidence.get("funnel")
    return {"configurations": [], "funnel": funnel, "failure": failure_wire(failure)}
