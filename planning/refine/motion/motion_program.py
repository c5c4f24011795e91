"""MotionTask and MotionProgram: what is optimized as a spline motion, and by which solver."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from jaxtyping import Float64

from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.motion.motion_cost import MotionCost
from planning.refine.motion.spline_motion import SplineMotion
from planning.refine.refine_problem import RefineProblem

OUT_OF_TIME = "the deadline passed during refinement"


@dataclass(frozen=True)
class MotionTask:
    """The optimization of one motion, whatever solves it.

    Attributes:
        problem: Path, limits, distances and deadline.
        bounds: Bounds on rates, as they are proven.
        cost: What is minimized.
        num_rest_points: Control points at either end that are fixed.
    """

    problem: RefineProblem
    bounds: RateBounds
    cost: MotionCost
    num_rest_points: int


@dataclass(frozen=True)
class Solution:
    """Where a solver ended.

    Attributes:
        motion: Optimal or not, free or not; its ends are those of the path.
        ending: Why the solver ended where that is not an optimum, or "".
        rounds: Programs that were solved.
    """

    motion: SplineMotion
    ending: str
    rounds: int


class MotionProgram(Protocol):
    """A solver for one task (interface)."""

    @property
    def task(self) -> MotionTask:
        """The task."""
        ...

    def solve(self, guess: SplineMotion, instants: Float64[np.ndarray, " m"]) -> Solution:
        """Return where the solver ended.

        Args:
            guess: The motion to begin with.
            instants: In (0, 1), at which margins and path constraints are kept.
        """
        ...
