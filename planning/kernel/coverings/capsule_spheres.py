"""Outer spheres of a capsule: equal balls along its axis."""

from math import sqrt

import numpy as np
from jaxtyping import Float64

_HALVINGS = 50


def capsule_spheres(
    radius: float, half_length: float, aim: float, most: int
) -> tuple[Float64[np.ndarray, "n 4"], float]:
    """Return the fewest balls of reach t at most `aim`, else `most` balls, and their reach [m].

    The balls are rows (x, y, z, r).

    Balls of radius r + t whose centres are no more than 2 h apart hold the cylinder of radius r
    between them where h^2 = (r + t)^2 - r^2, and the last ones, t before the ends of the axis, hold
    the balls of radius r there.

    Args:
        radius: Of the capsule, r [m].
        half_length: Of its cylindrical part [m].
        aim: Reach that suffices [m].
        most: Largest number of balls.
    """
    count, reach = 1, half_length
    while count < most and reach > aim:
        count += 1
        low, high = 0.0, half_length
        for _ in range(_HALVINGS):
            reach = (low + high) / 2
            is_enough = (count - 1) * sqrt(reach * (2 * radius + reach)) >= half_length - reach
            low, high = (low, reach) if is_enough else (reach, high)
        reach = high
    balls = np.zeros((count, 4))
    balls[:, 2] = np.linspace(reach - half_length, half_length - reach, count)
    balls[:, 3] = radius + reach
    return balls, reach
