"""Questions to a loaded scene: validity, forward and inverse kinematics, straight lines."""

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from planning import (
    Deadline,
    check_configurations,
    forward_kinematics,
    solve_ik,
    trace_line,
)
from planning.api.ik import assess_configurations
from planning.api.trace_line import TraceResolution
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
from service.api.failures.failure import Failure
from service.api.models import Pose
from service.jobs.context import TaskContext
from service.plans.models.constraints import constraints_to_domain
from service.plans.models.ik import IkFunnel
from service.queries.models.check import CheckRequest, CheckResponse, Verdict
from service.queries.models.kinematics import (
    FkRequest,
    FkResponse,
    IkRequest,
    IkResponse,
    IkSolution,
)
from service.queries.models.line import LineRequest, LineResponse
from service.queries.tasks import CHECK, FK, IK, LINE
from service.scenes.tasks import RequestWork
from service.scenes.world_cache import borrow_world

type Array = np.ndarray[Any, np.dtype[np.float64]]

_NO_SOLUTION = (
    ApproachBlocked,
    DeadlineExceeded,
    GoalInCollision,
    GoalTooNear,
    GoalUnreachable,
    GoalViolatesConstraint,
)


@CHECK.runs
def check(work: RequestWork[CheckRequest], _: TaskContext) -> CheckResponse:
    """Return a verdict per configuration.

    Raises:
        InputError: The group or a count is wrong.
    """
    request = work.request
    with borrow_world(work) as world:
        configurations = np.array(request.configurations, dtype=np.float64)
        verdicts = check_configurations(world, request.group, configurations, request.margin)
    return CheckResponse.model_construct(results=list(map(Verdict.from_domain, verdicts)))


@FK.runs
def fk(work: RequestWork[FkRequest], _: TaskContext) -> FkResponse:
    """Return the poses of frames per configuration.

    Raises:
        InputError: The group, a frame or a count is wrong.
    """
    request = work.request
    with borrow_world(work) as world:
        frames = tuple(request.frames or world.group(request.group).tool_frames)
        configurations = np.array(request.configurations, dtype=np.float64)
        found = forward_kinematics(world, request.group, configurations, frames)
    results = [
        {frame: Pose.from_domain(pose) for frame, pose in by_frame.items()} for by_frame in found
    ]
    return FkResponse.model_construct(results=results)


@IK.runs
def ik(work: RequestWork[IkRequest], context: TaskContext) -> IkResponse:
    """Return all goal configurations that were found, or why there is none.

    Raises:
        InputError: The group, a frame or a count is wrong.
        PlanningFailure: The start is invalid, or the answer is not wanted any more.
    """
    request, start = work.request, _start(work.request.start)
    deadline = Deadline.after(request.allowed_time, time.monotonic, context.is_canceled)
    goal = request.goal.to_domain()
    with borrow_world(work) as world:
        try:
            found = solve_ik(
                world,
                request.group,
                goal,
                deadline=deadline,
                start=start,
                options=request.ik.to_domain(),
                margin=request.margin,
                constraints=constraints_to_domain(request.path_constraints),
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
    return IkResponse(
        configurations=[IkSolution.from_domain(*solution) for solution in solutions],
        funnel=IkFunnel.model_validate(funnel_evidence(found.funnel)),
        failure=None,
    )


@LINE.runs
def line(work: RequestWork[LineRequest], context: TaskContext) -> LineResponse:
    """Return how far a tool can be moved in a straight line, and what stops it.

    Raises:
        InputError: The group, a frame or a count is wrong.
        PlanningFailure: Time ran out.
    """
    request = work.request
    deadline = Deadline.after(request.allowed_time, time.monotonic, context.is_canceled)
    with borrow_world(work) as world:
        trace = trace_line(
            world,
            request.group,
            request.to_target(),
            deadline=deadline,
            start=_start(request.start),
            frame=request.frame or "",
            margin=request.margin,
            fineness=TraceResolution(
                request.deviation.position, request.deviation.rotation, request.max_step
            ),
        )
    return LineResponse.from_domain(trace, with_poses=request.poses)


def _start(positions: Sequence[float] | None) -> Array | None:
    return None if positions is None else np.array(positions, dtype=np.float64)


def _no_configuration(failure: PlanningFailure) -> IkResponse:
    funnel = failure.evidence.get("funnel")
    return IkResponse(
        configurations=[],
        funnel=None if funnel is None else IkFunnel.model_validate(funnel),
        failure=Failure.from_error(failure),
    )
