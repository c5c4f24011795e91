"""Inner spheres: few balls inside a convex shape that leave little room beside them.

An object that enters the shape by more than the gap, the distance from a point of the surface to
the nearest ball, meets a ball. So each next ball is the one that lowers the squares of the gaps
most, and then each moves to where they are lowest.
"""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.kernel.coverings.ball_choices import BallChoices, directions
from planning.kernel.coverings.solid import Solid

type Array = np.ndarray[Any, np.dtype[np.float64]]

_MOST_BALLS = 8
# Balls smaller than this share of the largest are not worth a test.
_LEAST_SHARE = 0.05
# Least gain of one more ball.
_GAIN = 0.005
# Lengths of steps, over half the spacing of the choices.
_SHRINKING = 0.6 ** np.arange(5)
_STENCIL = directions(18)
# Accuracy of the faces of hulls, as a share of the shape's size.
_FACE_ACCURACY = 3e-7


def inner_spheres(solid: Solid, choices: BallChoices) -> Float64[np.ndarray, "n 4"]:
    """Return balls as rows (x, y, z, r), in decreasing order of benefit; each lies inside."""
    surface = choices.points[: choices.num_surface]
    accuracy = _FACE_ACCURACY * float((solid.high - solid.low).max())
    usable = choices.depths > max(accuracy, _LEAST_SHARE * float(choices.depths.max()))
    if not usable.any():
        return np.zeros((0, 4))
    squares = np.maximum(choices.gaps[usable, : len(surface)], 0.0) ** 2
    centers = choices.centers[usable]
    centers = centers[_taken(squares)]
    table = _squares(solid, surface, centers)
    for step in choices.spacing / 2 * _SHRINKING:
        tried = centers[:, None] + step * _STENCIL
        anew = _squares(solid, surface, tried.reshape(-1, 3)).reshape(*tried.shape[:2], -1)
        for i in range(len(centers)):
            left = np.delete(table, i, axis=0).min(axis=0, initial=np.inf)
            sums = np.minimum(anew[i], left).sum(axis=1)
            best = int(np.argmin(sums))
            if sums[best] < np.minimum(table[i], left).sum():
                centers[i], table[i] = tried[i, best], anew[i, best]
    return np.column_stack([centers, solid.depth(centers) - accuracy])


def _taken(squares: Float64[np.ndarray, "n m"]) -> list[int]:
    left = np.full(squares.shape[1], np.inf)
    taken: list[int] = []
    while len(taken) < _MOST_BALLS:
        best = int(np.argmin(np.minimum(squares, left).sum(axis=1)))
        lower = np.minimum(squares[best], left)
        if taken and lower.sum() > (1 - _GAIN) * left.sum():
            break
        taken.append(best)
        left = lower
    return taken


def _squares(solid: Solid, surface: Array, centers: Array) -> Float64[np.ndarray, "n m"]:
    depths = solid.depth(centers)
    gaps = np.linalg.norm(surface[None] - centers[:, None], axis=2) - depths[:, None]
    return np.where(depths[:, None] > 0, np.maximum(gaps, 0.0) ** 2, np.inf)
