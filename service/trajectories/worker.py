"""A client's own path, timed; a client's own trajectory, held against the scene."""

import dataclasses
import time
from typing import Any

import numpy as np

from planning import Deadline, RetimeOptions, certify_trajectory, retime_path
from planning.api.certify_trajectory import certify_positions
from planning.api.sample_motion import sample_motion
from planning.errors import PlanningFailure
from service.jobs.context import TaskContext
from service.plans.models.constraint_values import constraint_values
from service.plans.models.failures import failure_wire
from service.plans.models.goal_values import certify_value, retime_value
from service.plans.models.motion_limit_values import motion_limits
from service.plans.models.result_conversion import certificate_wire
from service.plans.models.trajectory_conversion import polynomial_wire, require_few, sampled_wire
from service.scenes.tasks import SceneWork
from service.scenes.world_cache import borrow_world
from service.trajectories.conversion import own_trajectory
from service.trajectories.models import CertifyMotionRequest, RetimeRequest


def retime(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return a certified motion along the path, or why there is none.

    Raises:
        InputError: The group or the waypoints do not fit the scene.
    """
    request = RetimeRequest.model_validate(payload["request"])
    with borrow_world(SceneWork.model_validate(payload)) as world:
        deadline = Deadline.after(request.allowed_time, time.monotonic, channel.is_canceled)
        kept: dict[str, Any] = {
            "options": retime_value(request.retime),
            "margin": request.margin,
            "constraints": constraint_values(request.path_constraints),
        }
        try:
            found = retime_path(
                world,
                request.group,
                np.array(request.waypoints, dtype=np.float64),
                deadline=deadline,
                certify_options=certify_value(request.certify),
                **kept,
            )
        except PlanningFailure as failure:
            nothing = dict.fromkeys(("trajectory", "certificate", "stages"))
            return {**nothing, "cut_short": [], "failure": failure_wire(failure)}
        cuts = set[str]()
        sampling = request.retime.sampling
        require_few(found.trajectory, sampling)
        proven = sample_motion(
            world,
            request.group,
            found.trajectory,
            sampling,
            deadline=deadline.with_on_expiry(lambda: cuts.add("samples")),
            clearance=found.certificate.proven_clearance,
            **kept,
        )
    return {
        "trajectory": {
            **sampled_wire(proven.samples, proven.interpolations),
            "polynomial": polynomial_wire(found.trajectory) if request.polynomial else None,
        },
        "certificate": certificate_wire(found.certificate),
        "stages": {
            "retime": dataclasses.asdict(found.retime),
            "certify": dataclasses.asdict(found.certify),
        },
        "cut_short": [*found.cut_short, *cuts],
        "failure": None,
    }


def certify(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return the certificate of a trajectory.

    Raises:
        InputError: The group or the trajectory do not fit the scene.
        DeadlineExceeded: Time ran out before the verdict.
    """
    request = CertifyMotionRequest.model_validate(payload["request"])
    with borrow_world(SceneWork.model_validate(payload)) as world:
        deadline = Deadline.after(request.allowed_time, time.monotonic, channel.is_canceled)
        trajectory, kind = own_trajectory(world.group(request.group), request.trajectory)
        held: dict[str, Any] = {
            "deadline": deadline,
            "options": RetimeOptions(
                method="ruckig" if request.limit_jerk else "toppra",
                **motion_limits(request),
            ),
            "start": request.start,
            "goal": request.goal,
            "margin": request.margin,
            "constraints": constraint_values(request.path_constraints),
        }
        if kind == "linear":
            certificate, report, unchecked = certify_positions(
                world, request.group, trajectory, **held
            )
        else:
            wanted, unchecked = certify_value(request.certify), ()
            certificate, report = certify_trajectory(
                world, request.group, trajectory, certify_options=wanted, **held
            )
    return {
        "certificate": certificate_wire(certificate),
        "interpolation": kind,
        "unchecked": list(unchecked),
        "duration": trajectory.duration,
        "stage": dataclasses.asdict(report),
    }
