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
from planning.search.cars.path_words import PathWords, root, shortest

# An angle this little short of a full turn counts as zero: it is a rounding error [rad].
_NOTHING = 1e-11
# Distance between centres below which two circles count as one [radii].
_ONE_CIRCLE = 1e-9


def dubins_words(goals: Float64[np.ndarray, "m 3"]) -> PathWords:
    """Return the shortest word to each goal: x, y [radii] and yaw in the frame of the start."""
    x, y, yaw = goals.T
    d, course = np.hypot(x, y), np.arctan2(y, x)
    a, b = -course, yaw - course
    left = d + np.sin(a) - np.sin(b), np.cos(a) - np.cos(b)
    right = d - np.sin(a) + np.sin(b), np.cos(a) - np.cos(b)
    with np.errstate(invalid="ignore"):
        words = [
            _outer(a, b, right),
            # A word that begins with a left turn is the mirror image of one that begins with a
            # right turn.
            _outer(-a, -b, left),
            _inner(a, b, d),
            _inner(-a, -b, d),
            _three_turns(a, b, d, right),
            _three_turns(-a, -b, d, left),
        ]
    return shortest(np.stack(words), _TURNS, goals)


_RIGHT_FIRST = np.array([[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [-1.0, 1.0, -1.0]])
_TURNS = np.stack([_RIGHT_FIRST, -_RIGHT_FIRST], axis=1).reshape(6, 3)


def _outer(a: Array, b: Array, centres: tuple[Array, Array]) -> Array:
    """Return the word RSR, given x and y of the line between the circles' centres."""
    line = np.hypot(*centres)
    # If the two circles coincide, the line has no direction: all of the turn is in the last
    # segment.
    course = np.where(line < _ONE_CIRCLE, a, np.arctan2(centres[1], centres[0]))
    return _word(a - course, line, course - b)


def _inner(a: Array, b: Array, d: Array) -> Array:
    """Return the word RSL, whose straight segment crosses the line between the circles' centres."""
    cosines, ahead = np.cos(a) + np.cos(b), d - np.sin(a) - np.sin(b)
    line = root(cosines**2 + ahead**2 - 4)
    course = np.arctan2(cosines, ahead) - np.arctan2(2.0, line)
    return _word(a - course, line, b - course)


def _three_turns(a: Array, b: Array, d: Array, centres: tuple[Array, Array]) -> Array:
    """Return the word RLR, given x and y of the line between the outer circles' centres."""
    cosine = (6 - d**2 + 2 * np.cos(a - b) + 2 * d * (np.sin(a) - np.sin(b))) / 8
    middle = 2 * np.pi - np.arccos(cosine)
    first = a - np.arctan2(centres[1], centres[0]) + middle / 2
    return _word(first, middle, a - b - first + middle)


def _word(first: Array, middle: Array, last: Array) -> Array:
    """Return the lengths of three segments, shape (m, 3), with first and last arcs in [0, 2 pi)."""
    return np.stack([_turn(first), middle, _turn(last)], axis=1)


def _turn(angle: Array) -> Array:
    """Return an angle in [0, 2 pi)."""
    turned = np.remainder(angle, 2 * np.pi)
    return np.where(turned > 2 * np.pi - _NOTHING, 0.0, turned)
