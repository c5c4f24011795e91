"""Power cells: a polytope shared out among balls.

A point belongs to the ball of least power |x - c|^2 - r^2. The cells are convex and leave nothing
out, whatever the balls are: so balls that are then made large enough, each for the corners of its
own cell, contain the polytope (Aurenhammer, "Power diagrams", 1987).
"""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.kernel.coverings.convex_polytope import ConvexPolytope

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Larger than every number of a face of the polytope itself.
_FIRST_FACE = 10_000


def power_cells(
    piece: ConvexPolytope, balls: Float64[np.ndarray, "n 4"], dust: float
) -> list[Array]:
    """Return the corners of every ball's cell; none if it has no share.

    Args:
        piece: What is shared out.
        balls: As rows (x, y, z, r); their centres differ by far more than `dust`.
        dust: How far each cell reaches into its neighbours, for rounding [m].
    """
    middle = piece.corners.mean(axis=0)
    centers = balls[:, :3] - middle
    powers = (centers**2).sum(axis=1) - balls[:, 3] ** 2
    normals = 2 * (centers[None] - centers[:, None])
    lengths = np.linalg.norm(normals, axis=2) + np.eye(len(balls))
    normals /= lengths[:, :, None]
    offsets = (powers[None] - powers[:, None]) / lengths + normals @ middle + dust
    cells: list[Array] = []
    for i, order in enumerate(np.argsort(lengths, axis=1, kind="stable")):
        cell = piece
        for face, j in enumerate(order[order != i], _FIRST_FACE):
            cell = cell.below(normals[i, j], float(offsets[i, j]), face)
            if not len(cell.corners):
                break
        cells.append(cell.corners)
    return cells
