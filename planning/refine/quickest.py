"""quickest(): descents from one guess after another, and the best curve of all."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.refine.basis import centres
from planning.refine.detour import Detour
from planning.refine.look import Look
from planning.refine.task import RefineTask
from planning.world.world import Array, World


@dataclass(frozen=True)
class Found:
    """What descents came to.

    Attributes:
        best: The best free curve, or None.
        steps: How many steps were taken.
        reason: Why the last curve of the last descent was refused, or "".
    """

    best: Look | None = None
    steps: int = 0
    reason: str = ""

    def descended(self, task: RefineTask, guess: Float64[np.ndarray, "k nv"]) -> "Found":
        """Return what there is after one more descent, from a guess."""
        other, more, reason = task.descend(guess)
        if self.best is None or (other is not None and other.worth < self.best.worth):
            return Found(other, self.steps + more, reason)
        return Found(self.best, self.steps + more, self.reason)


def quickest(world: World, task: RefineTask, guesses: list[Array]) -> Found:
    """Return the best of a few descents; others than the first only while nothing is good enough.

    Args:
        world: The scene, loaded.
        task: What every one of them needs.
        guesses: Control points of curves near the path, the next where the last led nowhere.
    """
    found = Found()
    for guess in guesses:
        if found.best is None and not task.share.is_over:
            found = found.descended(task, guess)
    if task.request.others.speed_zones and task.wants_more_than(found.best):
        found = _around(world, task, found, guesses[0])
    if found.best is not None and task.wants_more_than(found.best):
        found = found.descended(task, _straightened(found.best.points))
    return found


def _around(world: World, task: RefineTask, found: Found, points: Array) -> Found:
    """Return what there is once ways around speed zones, near a curve, have been tried."""
    detour = Detour.of(world, task.request, task.share)
    for guess in () if detour is None else detour.guesses(points):
        if detour is not None and task.wants_more_than(found.best):
            found = found.descended(detour.task, guess)
    return found


def _straightened(points: Array) -> Array:
    """Return control points halfway to the straight line between the ends.

    A descent stops on the side of obstacles where it began; from here others are as near.
    """
    straight = points[0] + centres(len(points))[:, None] * (points[-1] - points[0])
    return (points + straight) / 2
