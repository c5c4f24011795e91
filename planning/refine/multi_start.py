"""solve_multi_start(): local optimisation from several initial guesses; the best curve is kept."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from planning.refine.curves.bspline_basis import centres
from planning.refine.curves.curve_evaluation import CurveEvaluation
from planning.refine.refine_problem import RefineProblem
from planning.refine.zone_detour import ZoneDetour
from planning.world.world import Array, World

# Tolerances of the initial guesses to the path [rad or m]; the second is used if the first led to
# no free curve.
_CLOSE = (0.15, 0.04)


@dataclass(frozen=True)
class MultiStartResult:
    """Best curve over all local optimisations so far.

    Attributes:
        task: Refinement problem of the best curve, in whose coordinates the curve is.
        guess: Control points of the first guess, in the coordinates of the first problem.
        best: The best free curve, or None.
        steps: Number of trust-region steps.
        reason: Why the last curve of the last optimisation was rejected, or "".
    """

    task: RefineProblem
    guess: Array
    best: CurveEvaluation | None = None
    steps: int = 0
    reason: str = ""

    def descended(
        self, task: RefineProblem, guess: Float64[np.ndarray, "k nv"]
    ) -> "MultiStartResult":
        """Return the result after one more local optimisation, from another guess."""
        other, more, reason = task.descend(guess)
        steps = self.steps + more
        if self.best is None or (other is not None and other.worth < self.best.worth):
            return MultiStartResult(task, self.guess, other, steps, reason)
        return replace(self, steps=steps)


def solve_multi_start(world: World, task: RefineProblem) -> MultiStartResult:
    """Return the best of a few local optimisations; more of them only until one is good enough.

    Args:
        world: The scene, loaded.
        task: Refinement problem of the path.
    """
    guesses = [task.fitted(closeness) for closeness in _CLOSE]
    found = MultiStartResult(task, guesses[0], reason="no time was left")
    for guess in guesses:
        if found.best is None and not task.share.is_over:
            found = found.descended(task, guess)
    if task.chart.winds and task.wants_more_than(found.best):
        direct = RefineProblem.of(world, task.request.straight, task.share)
        found = found.descended(direct, direct.fitted(_CLOSE[0]))
    if task.request.others.speed_zones and task.wants_more_than(found.best):
        found = _around(world, found)
    if found.best is not None and task.wants_more_than(found.best):
        found = found.descended(found.task, _straightened(found.best.points))
    return found


def _around(world: World, found: MultiStartResult) -> MultiStartResult:
    """Return the result after local optimisations from guesses around speed zones."""
    task = found.task
    detour = ZoneDetour.of(world, task.request, task.share)
    for guess in () if detour is None else detour.guesses(task.fitted(_CLOSE[0])):
        if detour is not None and task.wants_more_than(found.best):
            found = found.descended(detour.task, guess)
    return found


def _straightened(points: Array) -> Array:
    """Return control points halfway to the straight line between the ends.

    A local optimisation stays on the side of obstacles where it began; from here others are as
    near.
    """
    straight = points[0] + centres(len(points))[:, None] * (points[-1] - points[0])
    return (points + straight) / 2
