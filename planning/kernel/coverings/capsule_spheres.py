"""Outer spheres of a capsule: equal balls along its axis."""

from math import sqrt

import numpy as np
from jaxtyping import Float64

_NUM_BISECTIONS = 50


def capsule_spheres(
    radius: float, half_length: float, target_reach: float, max_num_balls: int
) -> tuple[Float64[np.ndarray, "n 4"], float]:
    """Return the fewest balls of at most `target_reach`, else `max_num_balls`, and their reach [m].

    The balls are rows (x, y, z, r).

    Balls of radius r + t whose centres are no more than 2 h apart hold the cylinder of radius r
    between them where h^2 = (r + t)^2 - r^2, and the last ones, t before the ends of the axis, hold
    the balls of radius r there.

    Args:
        radius: Of the capsule, r [m].
        half_length: Of its cylindrical part [m].
        target_reach: Reach that suffices [m].
        max_num_balls: Largest number of balls.
    """
    num_balls, reach = 1, half_length
    while num_balls < max_num_balls and reach > target_reach:
        num_balls += 1
        low, high = 0.0, half_length
        for _ in range(_NUM_BISECTIONS):
            reach = (low + high) / 2
            is_enough = (num_balls - 1) * sqrt(reach * (2 * radius + reach)) >= half_length - reach
            low, high = (low, reach) if is_enough else (reach, high)
        reach = high
    balls = np.zeros((num_balls, 4))
    balls[:, 2] = np.linspace(reach - half_length, half_length - reach, num_balls)
    balls[:, 3] = radius + reach
    return balls, reach
