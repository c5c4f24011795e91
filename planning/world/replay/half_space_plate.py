"""Plate: a finite box that represents a half space in pictures."""

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import Box
from pydrake.math import RigidTransform

_THICKNESS = 0.01
# Its sides, over the size of the drawn bodies, and at least [m].
_WIDTH_PER_SIZE = 4.0
_MIN_WIDTH = 4.0


def plate_under(
    x_wg: RigidTransform, points: Float64[np.ndarray, "n 3"]
) -> tuple[Box, RigidTransform]:
    """Return a plate P whose top is in the plane of a half space G, and X_GP.

    It is wide enough to reach beyond the points, and below their middle, or about the half space's
    origin if there are none.

    Args:
        x_wg: Pose of the half space.
        points: Corners of the drawn bodies, in world [m].
    """
    middle, width = np.zeros(3), _MIN_WIDTH
    if len(points):
        local = (points - x_wg.translation()) @ x_wg.rotation().matrix()
        lower, upper = local.min(axis=0), local.max(axis=0)
        middle = (lower + upper) / 2
        width = max(width, _WIDTH_PER_SIZE * float(np.linalg.norm(upper - lower)))
    at = np.array([middle[0], middle[1], -_THICKNESS / 2])
    return Box(width, width, _THICKNESS), RigidTransform(at)
