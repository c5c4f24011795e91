"""Power cells (power diagram): partition of a polytope among balls.

A point belongs to the ball of least power |x - c|^2 - r^2. The cells are convex and cover the
polytope for any balls: so balls that are then made large enough, each for the corners of its own
cell, contain the polytope (Aurenhammer, "Power diagrams", 1987).
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.kernel.coverings.convex_polytope import ConvexPolytope

# Larger than every face index of the polytope itself.
_FIRST_FACE = 10_000


def power_cells(
    polytope: ConvexPolytope, balls: Float64[np.ndarray, "n 4"], rounding_margin: float
) -> list[Array]:
    """Return the corners of every ball's cell; none if its cell is empty.

    Args:
        polytope: The polytope.
        balls: As rows (x, y, z, r); their centres differ by far more than `rounding_margin`.
        rounding_margin: Rounding margin by which each cell reaches into its neighbours [m].
    """
    middle = polytope.corners.mean(axis=0)
    centers = balls[:, :3] - middle
    powers = (centers**2).sum(axis=1) - balls[:, 3] ** 2
    normals = 2 * (centers[None] - centers[:, None])
    lengths = np.linalg.norm(normals, axis=2) + np.eye(len(balls))
    normals /= lengths[:, :, None]
    offsets = (powers[None] - powers[:, None]) / lengths + normals @ middle + rounding_margin
    cells: list[Array] = []
    for i, order in enumerate(np.argsort(lengths, axis=1, kind="stable")):
        cell = polytope
        for face, j in enumerate(order[order != i], _FIRST_FACE):
            cell = cell.clipped(normals[i, j], float(offsets[i, j]), face)
            if not len(cell.corners):
                break
        cells.append(cell.corners)
    return cells
