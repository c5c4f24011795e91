"""Dubins curves: the shortest ways of a car that drives forwards only.

Each is one of six words of three letters: L or R, then S or the other turn, then L or R (Dubins,
"On curves of minimal length with a constraint on average curvature", 1957). The formulas are those
of Shkel and Lumelsky, "Classification of the Dubins set", Robotics and Autonomous Systems 34:4,
2001, where the goal is at a distance d in the direction of the x axis, and alpha and beta are the
yaws at the start and there.
"""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.search.cars.path_words import PathWords, root, shortest

type Array = np.ndarray[Any, np.dtype[np.float64]]

# An angle so little short of a whole turn is none: a rounding error is no reason to go around.
_NOTHING = 1e-11
# Circles that are this near are one [radii].
_ONE_CIRCLE = 1e-9


def dubins_words(goals: Float64[np.ndarray, "m 3"]) -> PathWords:
    """Return the shortest word to each goal: x, y [radii] and yaw, as the start sees them."""
    x, y, yaw = goals.T
    d, course = np.hypot(x, y), np.arctan2(y, x)
    a, b = -course, yaw - course
    left = d + np.sin(a) - np.sin(b), np.cos(a) - np.cos(b)
    right = d - np.sin(a) + np.sin(b), np.cos(a) - np.cos(b)
    with np.errstate(invalid="ignore"):
        words = [
            _outer(a, b, right),
            # What turns left first is the mirror image of what turns right first.
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
    """Return RSR; given are x and y of the line between the circles' centres."""
    line = np.hypot(*centres)
    # Of one circle that both are the line has no course: all of the turn is at the end.
    course = np.where(line < _ONE_CIRCLE, a, np.arctan2(centres[1], centres[0]))
    return _word(a - course, line, course - b)


def _inner(a: Array, b: Array, d: Array) -> Array:
    """Return RSL, whose line crosses the one between the circles' centres."""
    cosines, ahead = np.cos(a) + np.cos(b), d - np.sin(a) - np.sin(b)
    line = root(cosines**2 + ahead**2 - 4)
    course = np.arctan2(cosines, ahead) - np.arctan2(2.0, line)
    return _word(a - course, line, b - course)


def _three_turns(a: Array, b: Array, d: Array, centres: tuple[Array, Array]) -> Array:
    """Return RLR; given are x and y of the line between the outer circles' centres."""
    cosine = (6 - d**2 + 2 * np.cos(a - b) + 2 * d * (np.sin(a) - np.sin(b))) / 8
    middle = 2 * np.pi - np.arccos(cosine)
    first = a - np.arctan2(centres[1], centres[0]) + middle / 2
    return _word(first, middle, a - b - first + middle)


def _word(first: Array, middle: Array, last: Array) -> Array:
    """Return the lengths of three letters, shape (m, 3); those of arcs at the ends are wrapped."""
    return np.stack([_turn(first), middle, _turn(last)], axis=1)


def _turn(angle: Array) -> Array:
    """Return an angle in [0, 2 pi)."""
    turned = np.remainder(angle, 2 * np.pi)
    return np.where(turned > 2 * np.pi - _NOTHING, 0.0, turned)
