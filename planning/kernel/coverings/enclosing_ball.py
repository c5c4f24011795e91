"""Smallest enclosing ball of points, approximately."""

import numpy as np
from jaxtyping import Float64

_MAX_STEPS = 100
# Relative growth of the radius, more than its rounding errors.
_ROUNDING = 1e-12


def enclosing_ball(points: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "4"]:
    """Return a ball (x, y, z, r) that contains points, about a percent too large at most.

    Its centre takes ever smaller steps towards the farthest point (Badoiu and Clarkson, "Smaller
    core-sets for balls", 2003), beginning at the middle of the bounding box.
    """
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    best, center = np.append(middle, np.inf), middle
    for step in range(3, _MAX_STEPS):
        square = ((points - center) ** 2).sum(axis=1)
        farthest = int(np.argmax(square))
        radius = float(np.sqrt(square[farthest])) * (1 + _ROUNDING)
        if radius < best[3]:
            best = np.append(center, radius)
        center = center + (points[farthest] - center) / step
    return best
