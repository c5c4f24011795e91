"""Trajectories: sampled for the wire, and exactly there and back."""

from typing import Any

import numpy as np

from planning.domain.curve import TimedTrajectory
from planning.domain.joints import Joint, JointType
from planning.errors import ProblemInvalid
from service.convert.numbers import listed

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


def sampled_wire(
    trajectory: TimedTrajectory,
    period: float,
    num_points: int | None = None,
    names: tuple[str, str] = IN_BODY,
) -> dict[str, Any]:
    """Return the samples of a trajectory.

    Args:
        trajectory: What to sample.
        period: Between samples [s].
        num_points: How many samples instead, evenly in time; None for one every period.
        names: What the request calls these two.

    Raises:
        ProblemInvalid: That would be too many samples.
    """
    even = num_points is not None
    count = num_points if even else trajectory.duration / period
    if count > MAX_SAMPLES:
        message = (
            f"{names[0]}: a motion of {trajectory.duration:.4g} s with a sample every {period:g} s "
            f"would have more than {MAX_SAMPLES} samples; take a longer one, or `{names[1]}`"
        )
        raise ProblemInvalid(message, {"field": names[0], "bound": MAX_SAMPLES})
    times = trajectory.even_times(num_points) if even else trajectory.sample_times(period)
    return {
        "joint_names": [name for joint in trajectory.joints for name in joint.position_names],
        "velocity_names": [name for joint in trajectory.joints for name in joint.velocity_names],
        "times": listed(times),
        "positions": listed(trajectory.positions(times)),
        "velocities": listed(trajectory.velocities(times)),
        "accelerations": listed(trajectory.accelerations(times)),
        "duration": trajectory.duration,
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
