"""Inner spheres: few balls inside a convex shape that leave little room beside them.

An object that enters the shape by more than the gap, the distance from a point of the surface to
the nearest ball, meets a ball. So each next ball is the one that lowers the squares of the gaps
most, and then each moves to where they are lowest.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.kernel.coverings.ball_choices import BallChoices, fibonacci_directions
from planning.kernel.coverings.solid import Solid

_MAX_NUM_BALLS = 8
# Balls smaller than this share of the largest are not worth a test.
_MIN_RADIUS_RATIO = 0.05
# Least gain of one more ball.
_MIN_GAIN = 0.005
# Lengths of steps, over half the spacing of the choices.
_STEP_FACTORS = 0.6 ** np.arange(5)
_STENCIL = fibonacci_directions(18)
# Accuracy of the faces of hulls, as a share of the shape's size.
_FACE_ACCURACY = 3e-7


def inner_spheres(solid: Solid, choices: BallChoices) -> Float64[np.ndarray, "n 4"]:
    """Return balls as rows (x, y, z, r), in decreasing order of benefit; each lies inside."""
    surface = choices.points[: choices.num_surface]
    face_accuracy = _FACE_ACCURACY * float((solid.high - solid.low).max())
    usable = choices.depths > max(face_accuracy, _MIN_RADIUS_RATIO * float(choices.depths.max()))
    if not usable.any():
        return np.zeros((0, 4))
    squares = np.maximum(choices.gaps[usable, : len(surface)], 0.0) ** 2
    centers = choices.centers[usable]
    centers = centers[_choose_greedily(squares)]
    gap_squares = _squared_gaps(solid, surface, centers)
    for step in choices.spacing / 2 * _STEP_FACTORS:
        trial_centers = centers[:, None] + step * _STENCIL
        trial_squares = _squared_gaps(solid, surface, trial_centers.reshape(-1, 3)).reshape(
            *trial_centers.shape[:2], -1
        )
        for i in range(len(centers)):
            other_squares = np.delete(gap_squares, i, axis=0).min(axis=0, initial=np.inf)
            sums = np.minimum(trial_squares[i], other_squares).sum(axis=1)
            best = int(np.argmin(sums))
            if sums[best] < np.minimum(gap_squares[i], other_squares).sum():
                centers[i], gap_squares[i] = trial_centers[i, best], trial_squares[i, best]
    return np.column_stack([centers, solid.depth(centers) - face_accuracy])


def _choose_greedily(squares: Float64[np.ndarray, "n m"]) -> list[int]:
    min_squares = np.full(squares.shape[1], np.inf)
    chosen: list[int] = []
    while len(chosen) < _MAX_NUM_BALLS:
        best = int(np.argmin(np.minimum(squares, min_squares).sum(axis=1)))
        lowered = np.minimum(squares[best], min_squares)
        if chosen and lowered.sum() > (1 - _MIN_GAIN) * min_squares.sum():
            break
        chosen.append(best)
        min_squares = lowered
    return chosen


def _squared_gaps(solid: Solid, surface: Array, centers: Array) -> Float64[np.ndarray, "n m"]:
    depths = solid.depth(centers)
    gaps = np.linalg.norm(surface[None] - centers[:, None], axis=2) - depths[:, None]
    return np.where(depths[:, None] > 0, np.maximum(gaps, 0.0) ** 2, np.inf)
