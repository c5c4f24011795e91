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

from planning.search.words import Words, shortest

type Array = np.ndarray[Any, np.dtype[np.float64]]

# An angle so little short of a whole turn is none: a rounding error is no reason to go around.
_NOTHING = 1e-11


def dubins_words(goals: Float64[np.ndarray, "m 3"]) -> Words:
    """Return the shortest word to each goal: x, y [radii] and yaw, as the start sees them."""
    x, y, yaw = goals.T
    d, course = np.hypot(x, y), np.arctan2(y, x)
    a, b = -course, yaw - course
    sa, sb, ca, cb, cab = np.sin(a), np.sin(b), np.cos(a), np.cos(b), np.cos(a - b)
    with np.errstate(invalid="ignore"):
        words = [
            *_outer(a, b, (d + sa - sb, cb - ca), (d - sa + sb, ca - cb)),
            *_inner(a, b, d, (ca + cb, sa + sb), cab),
            _three_turns(a, b, (d - sa + sb, ca - cb), d),
            # What turns left first is the mirror image of what turns right first.
            _mirrored(_three_turns(-a, -b, (d + sa - sb, ca - cb), d)),
        ]
    return shortest(words, goals)


def _outer(
    a: Array, b: Array, left: tuple[Array, Array], right: tuple[Array, Array]
) -> list[Words]:
    """Return LSL and RSR; given are x and y of the line between the circles' centres."""
    course, other = np.arctan2(left[1], left[0]), np.arctan2(right[1], right[0])
    return [
        _word((course - a, b - course), np.hypot(*left), (1, 0, 1)),
        _word((a - other, other - b), np.hypot(*right), (-1, 0, -1)),
    ]


def _inner(a: Array, b: Array, d: Array, sums: tuple[Array, Array], cab: Array) -> list[Words]:
    """Return LSR and RSL, whose line crosses the one between the circles' centres."""
    cosines, sines = sums
    left = np.sqrt(d**2 - 2 + 2 * cab + 2 * d * sines)
    right = np.sqrt(d**2 - 2 + 2 * cab - 2 * d * sines)
    course = np.arctan2(-cosines, d + sines) - np.arctan2(-2.0, left)
    other = np.arctan2(cosines, d - sines) - np.arctan2(2.0, right)
    return [
        _word((course - a, course - b), left, (1, 0, -1)),
        _word((a - other, b - other), right, (-1, 0, 1)),
    ]


def _three_turns(a: Array, b: Array, centres: tuple[Array, Array], d: Array) -> Words:
    """Return RLR; given are x and y of the line between the outer circles' centres."""
    cosine = (6 - d**2 + 2 * np.cos(a - b) + 2 * d * (np.sin(a) - np.sin(b))) / 8
    middle = 2 * np.pi - np.arccos(cosine)
    first = a - np.arctan2(centres[1], centres[0]) + middle / 2
    return _word((first, a - b - first + middle), middle, (-1, 1, -1))


def _mirrored(word: Words) -> Words:
    return Words(word.lengths, -word.turns)


def _word(ends: tuple[Array, Array], middle: Array, turns: tuple[int, int, int]) -> Words:
    lengths = np.stack([_turn(ends[0]), middle, _turn(ends[1])], axis=1)
    return Words(np.where(np.isnan(middle)[:, None], np.inf, lengths), np.array(turns, float))


def _turn(angle: Array) -> Array:
    """Return an angle in [0, 2 pi)."""
    turned = np.remainder(angle, 2 * np.pi)
    return np.where(turned > 2 * np.pi - _NOTHING, 0.0, turned)
