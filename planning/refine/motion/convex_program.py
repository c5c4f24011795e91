"""ConvexProgram: a spline motion optimized by convex steps in a trust region."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.refine.descents.trust_region import TrustRegion
from planning.refine.motion.motion_model import MotionModel
from planning.refine.motion.motion_program import OUT_OF_TIME, MotionTask, Solution
from planning.refine.motion.spline_motion import SplineMotion

# Iterations, not seconds, decide when to give up, so that the same request gives the same bytes.
_MAX_STEPS = 30


@dataclass(frozen=True)
class ConvexProgram:
    """Convex steps for one task.

    Attributes:
        task: What is optimized.
    """

    task: MotionTask

    def solve(self, guess: SplineMotion, instants: Float64[np.ndarray, " m"]) -> Solution:
        """Return the motion of least merit, free or not; `MotionProgram` says more."""
        problem, count = self.task.problem, self.task.num_rest_points
        model = MotionModel(self.task, guess, instants)
        steps = TrustRegion(model, model.evaluate(model.within_limits(guess)))
        ending = ""
        for _ in steps.run(_MAX_STEPS):
            if problem.deadline.is_over:
                ending = OUT_OF_TIME
                break
        motion = steps.current.motion.with_ends_of(problem.waypoints, count)
        return Solution(motion, ending, steps.num_steps)
