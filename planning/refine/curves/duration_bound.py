"""Lower bound on the duration of any motion from rest to rest between two configurations."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointLimits
from planning.refine.constraints.rate_bounds import RateBounds


def least_duration(
    limits: JointLimits,
    moved: Float64[np.ndarray, " nv"],
    *,
    jerk: bool,
    signed: Float64[np.ndarray, "2 nv"] | None = None,
) -> float:
    """Return a lower bound of the duration from rest to rest [s].

    It is the largest over blocks of coordinates, each by itself along a straight line: full
    acceleration, full speed, full deceleration. A block's path is at least as long as the norm of
    its displacement, for rotations too.

    Args:
        limits: Of the group.
        moved: Displacement from start to goal [rad or m].
        jerk: Whether jerk is limited.
        signed: Lowest and highest accelerations in addition [rad/s^2 or m/s^2], infinite where
            there are none; only for blocks of one coordinate.
    """
    ways = np.array([np.linalg.norm(moved[list(block)]) for block in limits.blocks])
    alone = JointLimits(
        limits.lower,
        limits.upper,
        limits.velocity,
        limits.acceleration,
        limits.jerk,
        limits.effort,
        tuple((k,) for k in range(len(ways))),
    )
    firsts = [block[0] for block in limits.blocks]
    bounds = RateBounds.of(alone, jerk=jerk, signed=None if signed is None else signed[:, firsts])
    v, a = bounds.velocity, bounds.acceleration
    # Speeding up and slowing down take v / up + v / down; only the sum matters, not the distance.
    down, up = np.abs(bounds.signed)
    a = np.where(down == up, a, a * 2 * up * down / (up + down))
    return float(rest_to_rest(ways, v, a).max())


def rest_to_rest(ways: Array, speed: Any, acceleration: Any) -> Array:
    """Return the least durations of straight motions from rest to rest [s].

    Args:
        ways: Lengths [rad or m], not negative.
        speed: Bound on speed, infinite for none.
        acceleration: Bound on acceleration, likewise; one of both is finite.
    """
    with np.errstate(invalid="ignore"):
        is_short = ways * acceleration < speed * speed
    ramps = 2 * np.sqrt(ways / acceleration)
    return np.where(is_short, ramps, ways / speed + speed / acceleration)
