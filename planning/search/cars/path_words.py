"""PathWords: paths of a car as words of a few segments (arcs and lines), and the shortest of many.

A car of turning radius 1 starts at x = y = yaw = 0. Each segment (letter of the word) has a signed
length, negative for backwards, which for an arc is its angle too, and a turn: 1 to the left, -1 to
the right, 0 for straight ahead.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array

# Largest miss of the goal by a formula: formulas divide by values that may vanish [radii].
_GOAL_TOLERANCE = 1e-9
# Lengths that differ by less count as equal, so that rounding does not decide [radii].
_LENGTH_TOLERANCE = 1e-9
# Squares that are negative by no more than this count as zero [radii^2].
_SQUARE_TOLERANCE = 1e-12


@dataclass(frozen=True)
class PathWords:
    """One path word for each of several goals.

    Attributes:
        lengths: Signed lengths of the segments [radii], shape (m, k).
        turns: Turns of the segments: 1 left, -1 right, 0 straight, shape (m, k).
    """

    lengths: Float64[np.ndarray, "m k"]
    turns: Float64[np.ndarray, "m k"]


def shortest_words(
    lengths: Float64[np.ndarray, "w m k"],
    turns: Float64[np.ndarray, "w k"],
    goals: Float64[np.ndarray, "m 3"],
) -> PathWords:
    """Return the shortest word for each goal, of those that end there; the first of equal ones.

    Args:
        lengths: Lengths of w words for each goal, infinite where a word does not exist [radii].
        turns: Turns of the segments of each of the w words.
        goals: x, y [radii] and yaw.
    """
    totals = np.abs(lengths).sum(axis=2)
    totals[np.isnan(totals)] = np.inf
    rows = np.arange(len(goals))
    while True:
        best = np.argmax(totals <= totals.min(axis=0) + _LENGTH_TOLERANCE, axis=0)
        chosen = PathWords(lengths[best, rows], turns[best])
        x, y, yaw = end_poses(chosen.lengths, chosen.turns)
        yaw_error = np.remainder(yaw - goals[:, 2] + np.pi, 2 * np.pi) - np.pi
        goal_error = np.hypot(x - goals[:, 0], y - goals[:, 1]) + np.abs(yaw_error)
        missed = np.flatnonzero(goal_error > _GOAL_TOLERANCE * (1 + totals[best, rows]))
        if not len(missed):
            return chosen
        totals[best[missed], missed] = np.inf


def rounded_sqrt(square: Array) -> Array:
    """Return the square root, zero where rounding has made the square negative; NaN below that."""
    return np.sqrt(np.where(square > -_SQUARE_TOLERANCE, np.maximum(square, 0.0), np.nan))


def end_poses(lengths: Array, turns: Array) -> tuple[Array, Array, Array]:
    """Return x, y [radii] and yaw at the ends of words whose segments are along the last axis."""
    after = np.cumsum(lengths * turns, axis=-1)
    before = after - lengths * turns
    is_arc = turns != 0
    divisors = np.where(is_arc, turns, 1.0)
    x = np.where(is_arc, (np.sin(after) - np.sin(before)) / divisors, lengths * np.cos(before))
    y = np.where(is_arc, (np.cos(before) - np.cos(after)) / divisors, lengths * np.sin(before))
    return x.sum(axis=-1), y.sum(axis=-1), after[..., -1]
