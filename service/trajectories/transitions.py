"""A running motion, stopped or left for another one."""

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from planning import Deadline, RetimeOptions, TimedTrajectory, World, splice_motion, stop_motion
from planning.api.sample_motion import sample_motion
from planning.api.splice_motion import ProvenMotion
from planning.domain.robot.joints import JointGroup
from planning.errors import PlanningFailure, ProblemInvalid
from service.jobs.context import TaskContext
from service.plans.models.constraint_values import constraint_values
from service.plans.models.failures import failure_wire
from service.plans.models.motion_limit_values import motion_limits
from service.plans.models.result_conversion import certificate_wire
from service.plans.models.trajectory_conversion import (
    IN_QUESTION,
    polynomial_wire,
    require_few,
    sampled_wire,
)
from service.scenes.tasks import SceneWork
from service.scenes.world_cache import borrow_world
from service.trajectories.conversion import own_trajectory
from service.trajectories.models import OwnTrajectory
from service.trajectories.transition_models import SpliceMotionRequest, StopMotionRequest


def stop(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return a certified stop, or why there is none.

    Raises:
        InputError: The group, the motion, the instant or a limit do not fit the scene.
    """
    request = StopMotionRequest.model_validate(payload["request"])
    with borrow_world(SceneWork.model_validate(payload)) as world:
        running, kind = _running(world.group(request.group), request.trajectory, "trajectory")
        held = _held(request, channel, jerk=request.limit_jerk)
        along = request.along_path
        found = _found(
            request,
            _Leaving(world, running, held),
            lambda: stop_motion(
                world, request.group, running, request.time, along_path=along, **held
            ),
        )
    return {**found, "interpolation": kind}


def splice(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return a certified way over into another motion and that motion's rest, or why there is none.

    Raises:
        InputError: The group, a motion, the instant or a limit do not fit the scene.
    """
    request = SpliceMotionRequest.model_validate(payload["request"])
    with borrow_world(SceneWork.model_validate(payload)) as world:
        group = world.group(request.group)
        running, kind = _running(group, request.trajectory, "trajectory")
        onto, other = _running(group, request.onto, "onto")
        held = _held(request, channel, jerk=True)
        found = _found(
            request,
            _Leaving(world, running, held),
            lambda: splice_motion(world, request.group, running, request.time, onto, **held),
        )
    return {**found, "interpolation": kind, "onto_interpolation": other}


def _running(group: JointGroup, wire: OwnTrajectory, field: str) -> tuple[TimedTrajectory, str]:
    """Return a motion that can be left or joined, and what its samples were taken for.

    Raises:
        InputError: It does not fit the group, or has corners.
    """
    motion, kind = own_trajectory(group, wire, field)
    if kind == "linear":
        message = f"{field}.interpolation: straight lines have corners, where nothing can be joined"
        raise ProblemInvalid(message, {"field": f"{field}.interpolation"})
    return motion, kind


def _held(
    request: StopMotionRequest | SpliceMotionRequest, channel: TaskContext, *, jerk: bool
) -> dict[str, Any]:
    """Return what holds on the way."""
    method = "ruckig" if jerk else "toppra"
    return {
        "deadline": Deadline.after(request.allowed_time, time.monotonic, channel.is_canceled),
        "options": RetimeOptions(method=method, **motion_limits(request)),
        "constraints": constraint_values(request.path_constraints),
        "margin": request.margin,
    }


@dataclass(frozen=True)
class _Leaving:
    """What is left, and what holds on the way."""

    world: World
    running: TimedTrajectory
    held: dict[str, Any]


def _found(
    request: StopMotionRequest | SpliceMotionRequest,
    leaving: _Leaving,
    leave: Callable[[], ProvenMotion],
) -> dict[str, Any]:
    try:
        found = leave()
    except PlanningFailure as failure:
        nothing = dict.fromkeys(("trajectory", "certificate", "stage"))
        return {**nothing, "failure": failure_wire(failure)}
    motion = found.trajectory
    require_few(motion, request.sampling, IN_QUESTION)
    proven = sample_motion(
        leaving.world,
        request.group,
        motion,
        request.sampling,
        clearance=found.certificate.proven_clearance,
        origin=leaving.running.start,
        **leaving.held,
    )
    return {
        "trajectory": {
            **sampled_wire(proven.samples, proven.interpolations),
            "polynomial": polynomial_wire(motion) if request.polynomial else None,
        },
        "certificate": certificate_wire(found.certificate),
        "stage": dataclasses.asdict(found.certify),
        "failure": None,
    }
