"""Lower bound on the duration of any motion from rest to rest between two configurations."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointLimits
from planning.refine.constraints.rate_bounds import RateBounds


def duration_lower_bound(
    limits: JointLimits,
    displacement: Float64[np.ndarray, " nv"],
    *,
    limits_jerk: bool,
    acceleration_bounds: Float64[np.ndarray, "2 nv"] | None = None,
) -> float:
    """Return a lower bound of the duration from rest to rest [s].

    It is the largest over blocks of coordinates, each by itself along a straight line: full
    acceleration, full speed, full deceleration. A block's path is at least as long as the norm of
    its displacement, for rotations too.

    Args:
        limits: Joint limits of the group.
        displacement: Displacement from start to goal [rad or m].
        limits_jerk: Whether jerk is limited.
        acceleration_bounds: Lowest and highest accelerations in addition [rad/s^2 or m/s^2],
            infinite where there are none; only for blocks of one coordinate.
    """
    distances = np.array([np.linalg.norm(displacement[list(block)]) for block in limits.blocks])
    scalar_limits = JointLimits(
        limits.lower,
        limits.upper,
        limits.velocity,
        limits.acceleration,
        limits.jerk,
        limits.effort,
        tuple((k,) for k in range(len(distances))),
    )
    first_indices = [block[0] for block in limits.blocks]
    if acceleration_bounds is not None:
        acceleration_bounds = acceleration_bounds[:, first_indices]
    bounds = RateBounds.of(
        scalar_limits, limits_jerk=limits_jerk, acceleration_bounds=acceleration_bounds
    )
    v, a = bounds.velocity, bounds.acceleration
    # Speeding up and slowing down take v / up + v / down; only the sum matters, not the distance.
    down, up = np.abs(bounds.acceleration_range)
    a = np.where(down == up, a, a * 2 * up * down / (up + down))
    return float(rest_to_rest_durations(distances, v, a).max())


def rest_to_rest_durations(distances: Array, speed: Any, acceleration: Any) -> Array:
    """Return the least durations of straight motions from rest to rest [s].

    Args:
        distances: Lengths [rad or m], not negative.
        speed: Bound on speed, infinite for none.
        acceleration: Bound on acceleration, likewise; at least one of the two is finite.
    """
    with np.errstate(invalid="ignore"):
        is_short = distances * acceleration < speed * speed
    triangular_durations = 2 * np.sqrt(distances / acceleration)
    return np.where(is_short, triangular_durations, distances / speed + speed / acceleration)
