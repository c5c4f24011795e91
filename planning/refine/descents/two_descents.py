"""two_descents(): a descent from a guess, and one from nearer to the straight line, in turns.

A descent stays on the side of obstacles where it began, and one on the longer side may creep along
them to its last step, where another one would reach the least possible duration within a few. So
neither is finished before the other one was given a chance: after some steps of the first, the
second begins at its curve, drawn to the straight line between its ends; the one that is ahead then
goes on, and the one behind only as long as it may still get below the other.
"""

from typing import Protocol

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.refine.curves.bspline_basis import greville_abscissae
from planning.refine.curves.curve_evaluation import CurveEvaluation
from planning.refine.descents.descent import Descent

# Number of steps of the first descent before the second begins, and of that before both are
# compared: the steps it takes to leave the obstacles that the straight line is in.
_FIRST_STEPS, _SECOND_STEPS = 6, 7
# Number of steps within which the descent that is behind has to get below the other one.
_FORESEEN_STEPS = 3
# Factor above the least possible duration below which the first descent is finished first.
_NEAR_RATIO = 1.1
# Share of the way to the straight line at which the second descent begins.
_STRAIGHT_SHARE = 0.75


class Descendable(Protocol):
    """What two descents ask of their problem."""

    @property
    def lower_bound(self) -> float:
        """Lower bound of the duration of all motions from start to goal [s]."""
        ...

    def descent(self, guess: Array, /) -> Descent:
        """Return a descent from a guess, before its first step."""
        ...

    def needs_another_start(self, best: CurveEvaluation | None, /) -> bool:
        """Return whether time remains for another guess and the best curve is slow enough."""
        ...


def two_descents(problem: Descendable, guess: Float64[np.ndarray, "k nv"]) -> tuple[Descent, ...]:
    """Return a descent from a guess, and the second one if it is of use; both have ended.

    Args:
        problem: Whose curves are optimized.
        guess: Control points of a curve near the path.
    """
    first = problem.descent(guess)
    first.advance(max_steps=_FIRST_STEPS)
    if first.merit <= _NEAR_RATIO * problem.lower_bound:
        first.advance()
    has_failed = first.is_finished and first.best is None
    if has_failed or not problem.needs_another_start(first.best):
        return (first,)
    second = problem.descent(_toward_straight_line(first.points))
    second.advance(max_steps=_SECOND_STEPS)
    ahead, behind = (second, first) if second.merit < first.merit else (first, second)
    ahead.advance()
    if problem.needs_another_start(ahead.best):
        to_beat = np.inf if ahead.best is None else ahead.best.objective
        behind.advance(to_beat, num_foreseen=_FORESEEN_STEPS)
    return first, second


def _toward_straight_line(points: Array) -> Array:
    """Return control points most of the way to the straight line between the ends."""
    straight = points[0] + greville_abscissae(len(points))[:, None] * (points[-1] - points[0])
    return points + _STRAIGHT_SHARE * (straight - points)
