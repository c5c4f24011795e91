"""Trajectories: sampled for the wire, and exactly there and back."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.interpolation_proof import InterpolationProof
from planning.domain.curves.sampling import SampledTrajectory, Sampling
from planning.domain.report.certificate import Check
from planning.domain.robot.joints import Joint, JointType
from planning.errors import ProblemInvalid
from service.api.models import finite, listed

MAX_SAMPLES = 200_000
# Where requests say how to sample: fields of a body, deep in it or not, or parameters of a query.
IN_BODY = ("retime.sample_period", "retime.num_points")
IN_QUESTION = ("sample_period", "num_points")
IN_QUERY = ("period", "points")


def require_one_sampling(
    period: float | None, num_points: int | None, names: tuple[str, str] = IN_BODY
) -> None:
    """Go on only if a request does not say twice how to sample.

    Args:
        period: Between samples [s]; None if it is not given.
        num_points: How many samples; None if it is not given.
        names: What the request calls these two.

    Raises:
        ProblemInvalid: Both are given.
    """
    if period is not None and num_points is not None:
        message = f"`{names[0]}` and `{names[1]}` cannot both be given: one follows from the other"
        raise ProblemInvalid(message, {"field": names[1]})


def require_few(
    trajectory: TimedTrajectory, sampling: Sampling, names: tuple[str, str] = IN_BODY
) -> None:
    """Go on only if a motion has not too many samples.

    Args:
        trajectory: What to sample.
        sampling: At which instants.
        names: What the request calls the period and the number of points.

    Raises:
        ProblemInvalid: That would be too many samples.
    """
    count = sampling.num_points or trajectory.duration / sampling.period
    if count > MAX_SAMPLES:
        message = (
            f"{names[0]}: a motion of {trajectory.duration:.4g} s with a sample every "
            f"{sampling.period:g} s would have more than {MAX_SAMPLES} samples; take a longer one, "
            f"or `{names[1]}`"
        )
        raise ProblemInvalid(message, {"field": names[0], "bound": MAX_SAMPLES})


def sampled_wire(
    samples: SampledTrajectory, interpolations: Sequence[InterpolationProof]
) -> dict[str, Any]:
    """Return the samples of a trajectory, and what is proven of them."""
    return {
        "joint_names": [name for joint in samples.joints for name in joint.position_names],
        "velocity_names": [name for joint in samples.joints for name in joint.velocity_names],
        "times": listed(samples.times),
        "positions": listed(samples.positions),
        "velocities": listed(samples.velocities),
        "accelerations": listed(samples.accelerations),
        "duration": float(samples.times[-1]),
        "interpolations": [_interpolation_wire(proof) for proof in interpolations],
        "polynomial": None,
    }


def _interpolation_wire(proof: InterpolationProof) -> dict[str, Any]:
    return {
        "kind": proof.kind,
        "proven": proof.proven,
        "deviation": finite(proof.deviation),
        "up_to_period": proof.up_to_period,
        "failed": [check_wire(check) for check in proof.failed],
        "unchecked": list(proof.unchecked),
        "reason": proof.reason,
    }


def check_wire(check: Check) -> dict[str, Any]:
    """Return a check for the wire."""
    return {
        **dataclasses.asdict(check),
        "value": finite(check.value),
        "bound": finite(check.bound),
        "resolution": finite(check.resolution),
    }


def polynomial_wire(trajectory: TimedTrajectory) -> dict[str, Any]:
    """Return the exact trajectory: floats survive JSON bit for bit."""
    return {
        "breaks": listed(trajectory.breaks),
        "bases": listed(trajectory.bases),
        "coefficients": listed(trajectory.coefficients),
        "joint_names": [joint.name for joint in trajectory.joints],
        "joint_types": [str(joint.type) for joint in trajectory.joints],
    }


def trajectory_value(polynomial: dict[str, Any]) -> TimedTrajectory:
    """Return the trajectory that `polynomial_wire` wrote."""
    names, types = polynomial["joint_names"], polynomial["joint_types"]
    joints = tuple(Joint(name, JointType(kind)) for name, kind in zip(names, types, strict=True))
    return TimedTrajectory(
        joints,
        np.array(polynomial["breaks"], dtype=np.float64),
        np.array(polynomial["bases"], dtype=np.float64),
        np.array(polynomial["coefficients"], dtype=np.float64),
    )
