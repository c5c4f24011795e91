"""A bound on durations that no motion beats, whatever its way."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.joints import JointLimits
from planning.refine.pace import Bounds

type Array = np.ndarray[Any, np.dtype[np.float64]]


def least_duration(limits: JointLimits, moved: Float64[np.ndarray, " nv"], *, jerk: bool) -> float:
    """Return the time that no motion from rest to rest beats [s].

    Every block of coordinates by itself: full acceleration, full speed, full deceleration, straight
    ahead. That the norm of a block's displacement is at most what it covers holds for rotations,
    too.

    Args:
        limits: Of the group.
        moved: From start to goal [rad or m].
        jerk: Whether jerk is limited.
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
    bounds = Bounds.of(alone, jerk=jerk)
    v, a = bounds.velocity, bounds.acceleration
    return float(np.where(ways * a < v * v, 2 * np.sqrt(ways / a), ways / v + v / a).max())
