"""Dubins curves: the shortest paths of a car that drives forwards only.

Each is one of six words of three segments: L or R, then S or the opposite turn, then L or R
(Dubins, "On curves of minimal length with a constraint on average curvature", 1957). The formulas
are those of Shkel and Lumelsky, "Classification of the Dubins set", Robotics and Autonomous Systems
34:4, 2001, where the goal is at a distance d in the direction of the x axis, and alpha and beta are
the yaws at the start and at the goal.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.search.cars.path_words import PathWords, rounded_sqrt, shortest_words

# An angle this little short of a full turn counts as zero: it is a rounding error [rad].
_ANGLE_ROUNDING = 1e-11
# Distance between centres below which two circles count as one [radii].
_CENTRE_TOLERANCE = 1e-9


def dubins_words(goals: Float64[np.ndarray, "m 3"]) -> PathWords:
    """Return the shortest word to each goal: x, y [radii] and yaw in the frame of the start."""
    x, y, yaw = goals.T
    d, direction = np.hypot(x, y), np.arctan2(y, x)
    a, b = -direction, yaw - direction
    left = d + np.sin(a) - np.sin(b), np.cos(a) - np.cos(b)
    right = d - np.sin(a) + np.sin(b), np.cos(a) - np.cos(b)
    with np.errstate(invalid="ignore"):
        words = [
            _rsr(a, b, right),
            # A word that begins with a left turn is the mirror image of one that begins with a
            # right turn.
            _rsr(-a, -b, left),
            _rsl(a, b, d),
            _rsl(-a, -b, d),
            _rlr(a, b, d, right),
            _rlr(-a, -b, d, left),
        ]
    return shortest_words(np.stack(words), _TURNS, goals)


_RIGHT_FIRST = np.array([[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [-1.0, 1.0, -1.0]])
_TURNS = np.stack([_RIGHT_FIRST, -_RIGHT_FIRST], axis=1).reshape(6, 3)


def _rsr(a: Array, b: Array, centres: tuple[Array, Array]) -> Array:
    """Return the word RSR, given x and y of the line between the circles' centres."""
    line = np.hypot(*centres)
    # If the two circles coincide, the line has no direction: all of the turn is in the last
    # segment.
    direction = np.where(line < _CENTRE_TOLERANCE, a, np.arctan2(centres[1], centres[0]))
    return _segment_lengths(a - direction, line, direction - b)


def _rsl(a: Array, b: Array, d: Array) -> Array:
    """Return the word RSL, whose straight segment crosses the line between the circles' centres."""
    cosines, ahead = np.cos(a) + np.cos(b), d - np.sin(a) - np.sin(b)
    line = rounded_sqrt(cosines**2 + ahead**2 - 4)
    direction = np.arctan2(cosines, ahead) - np.arctan2(2.0, line)
    return _segment_lengths(a - direction, line, b - direction)


def _rlr(a: Array, b: Array, d: Array, centres: tuple[Array, Array]) -> Array:
    """Return the word RLR, given x and y of the line between the outer circles' centres."""
    cosine = (6 - d**2 + 2 * np.cos(a - b) + 2 * d * (np.sin(a) - np.sin(b))) / 8
    middle = 2 * np.pi - np.arccos(cosine)
    first = a - np.arctan2(centres[1], centres[0]) + middle / 2
    return _segment_lengths(first, middle, a - b - first + middle)


def _segment_lengths(first: Array, middle: Array, last: Array) -> Array:
    """Return the lengths of three segments, shape (m, 3), with first and last arcs in [0, 2 pi)."""
    return np.stack([_wrap_angle(first), middle, _wrap_angle(last)], axis=1)


def _wrap_angle(angle: Array) -> Array:
    """Return an angle in [0, 2 pi)."""
    wrapped = np.remainder(angle, 2 * np.pi)
    return np.where(wrapped > 2 * np.pi - _ANGLE_ROUNDING, 0.0, wrapped)
