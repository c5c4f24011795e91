"""solve_multi_start(): local optimization from several initial guesses; the best curve is kept."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.refine.curves.curve_evaluation import CurveEvaluation
from planning.refine.descents.descent import Descent
from planning.refine.descents.two_descents import two_descents
from planning.refine.refine_problem import RefineProblem
from planning.refine.zone_detour import ZoneDetour
from planning.world.world import World

# Tolerances of the initial guesses to the path [rad or m]; the second is used if the first led to
# no free curve.
_FIT_TOLERANCES = (0.15, 0.04)


@dataclass(frozen=True)
class MultiStartResult:
    """Best curve over all local optimizations so far.

    Attributes:
        problem: Refinement problem of the best curve, in whose coordinates the curve is.
        first_guess: Control points of the first guess, in the coordinates of the first problem.
        best: The best free curve, or None.
        num_steps: Number of trust-region steps.
        reason: Why the last curve of the last optimization was rejected, or "".
    """

    problem: RefineProblem
    first_guess: Array
    best: CurveEvaluation | None = None
    num_steps: int = 0
    reason: str = ""

    def optimized_from(
        self, problem: RefineProblem, guess: Float64[np.ndarray, "k nv"]
    ) -> "MultiStartResult":
        """Return the result after one more descent, from another guess."""
        descent = problem.descent(guess)
        descent.advance(np.inf if self.best is None else self.best.objective)
        return self.with_descent(problem, descent)

    def with_two_descents(
        self, problem: RefineProblem, guess: Float64[np.ndarray, "k nv"]
    ) -> "MultiStartResult":
        """Return the result after a descent from another guess, and one nearer to a straight line.

        The second one is left out where the first one leads to a curve that is good enough.
        """
        result = self
        for descent in two_descents(problem, guess):
            result = result.with_descent(problem, descent)
        return result

    def with_descent(self, problem: RefineProblem, descent: Descent) -> "MultiStartResult":
        """Return the result after one more descent, which has ended."""
        num_steps, candidate = self.num_steps + descent.num_steps, descent.best
        if self.best is None or (
            candidate is not None and candidate.objective < self.best.objective
        ):
            reason = descent.reason
            return MultiStartResult(problem, self.first_guess, candidate, num_steps, reason)
        return replace(self, num_steps=num_steps)


def solve_multi_start(world: World, problem: RefineProblem) -> MultiStartResult:
    """Return the best of a few local optimizations; they end when one is good enough.

    Args:
        world: The scene, loaded.
        problem: Refinement problem of the path.
    """
    guess = problem.fit_path(_FIT_TOLERANCES[0])
    result = MultiStartResult(problem, guess, reason="the deadline passed during refinement")
    if problem.deadline.is_over:
        return result
    result = result.with_two_descents(problem, guess)
    if result.best is None and not problem.deadline.is_over:
        result = result.with_two_descents(problem, problem.fit_path(_FIT_TOLERANCES[1]))
    return _from_other_guesses(world, problem, result)


def _from_other_guesses(
    world: World, problem: RefineProblem, result: MultiStartResult
) -> MultiStartResult:
    """Return the result after descents from other guesses, as long as they are needed."""
    if problem.chart.is_winding and problem.needs_another_start(result.best):
        straight_problem = RefineProblem.of(world, problem.request.straight, problem.deadline)
        result = result.optimized_from(
            straight_problem, straight_problem.fit_path(_FIT_TOLERANCES[0])
        )
    if problem.request.motion_limits.speed_zones and problem.needs_another_start(result.best):
        result = _around_speed_zones(world, result)
    return result


def _around_speed_zones(world: World, result: MultiStartResult) -> MultiStartResult:
    """Return the result after local optimizations from guesses around speed zones."""
    problem = result.problem
    detour = ZoneDetour.of(world, problem.request, problem.deadline)
    for guess in () if detour is None else detour.guesses(problem.fit_path(_FIT_TOLERANCES[0])):
        if detour is not None and problem.needs_another_start(result.best):
            result = result.optimized_from(detour.problem, guess)
    return result
