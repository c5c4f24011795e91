"""PathWords: ways of a car as a few arcs and lines, and the shortest of many.

A car of turning radius 1 starts at x = y = yaw = 0. Each letter of a word is a signed length, of an
arc that is its angle too, negative for backwards, and a turn: 1 to the left, -1 to the right, 0 for
straight ahead.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

type Array = np.ndarray[Any, np.dtype[np.float64]]

# A formula that misses its goal by more is not for it: they divide by what may vanish [radii].
_MISS = 1e-9
# Lengths that differ by less are equal, so that rounding does not choose [radii].
_EQUAL = 1e-9
# Squares that are less than zero by so much are zero [radii^2].
_ROUNDED = 1e-12


@dataclass(frozen=True)
class PathWords:
    """One word for each of several goals.

    Attributes:
        lengths: Of each letter [radii], shape (m, k).
        turns: Of each letter, shape (m, k).
    """

    lengths: Float64[np.ndarray, "m k"]
    turns: Float64[np.ndarray, "m k"]


def shortest(
    lengths: Float64[np.ndarray, "w m k"],
    turns: Float64[np.ndarray, "w k"],
    goals: Float64[np.ndarray, "m 3"],
) -> PathWords:
    """Return the shortest word to each goal of those that lead there, the first of equals.

    Args:
        lengths: Of w words to each goal, infinite where a word is none [radii].
        turns: Of the letters of each of the w.
        goals: x, y [radii] and yaw.
    """
    totals = np.abs(lengths).sum(axis=2)
    totals[np.isnan(totals)] = np.inf
    rows = np.arange(len(goals))
    while True:
        best = np.argmax(totals <= totals.min(axis=0) + _EQUAL, axis=0)
        chosen = PathWords(lengths[best, rows], turns[best])
        x, y, yaw = end_of(chosen.lengths, chosen.turns)
        turn = np.remainder(yaw - goals[:, 2] + np.pi, 2 * np.pi) - np.pi
        miss = np.hypot(x - goals[:, 0], y - goals[:, 1]) + np.abs(turn)
        lost = np.flatnonzero(miss > _MISS * (1 + totals[best, rows]))
        if not len(lost):
            return chosen
        totals[best[lost], lost] = np.inf


def root(square: Array) -> Array:
    """Return the square root, of what rounding has made negative too; NaN of the rest."""
    return np.sqrt(np.where(square > -_ROUNDED, np.maximum(square, 0.0), np.nan))


def end_of(lengths: Array, turns: Array) -> tuple[Array, Array, Array]:
    """Return x, y [radii] and yaw where words end, whose letters are along the last axis."""
    after = np.cumsum(lengths * turns, axis=-1)
    before = after - lengths * turns
    is_arc = turns != 0
    safe = np.where(is_arc, turns, 1.0)
    x = np.where(is_arc, (np.sin(after) - np.sin(before)) / safe, lengths * np.cos(before))
    y = np.where(is_arc, (np.cos(before) - np.cos(after)) / safe, lengths * np.sin(before))
    return x.sum(axis=-1), y.sum(axis=-1), after[..., -1]
