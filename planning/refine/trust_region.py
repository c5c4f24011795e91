"""TrustRegion: steps of the sequential convex program within a box that grows and shrinks by merit.

The box around the control points grows where the convex model predicts the decrease of the cost
well, and shrinks where it does not (Nocedal and Wright, "Numerical Optimization", 2006, ch. 4).
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64

from planning.refine.curves.curve_evaluation import CurveEvaluation
from planning.refine.model.curve_model import CurveModel

# Half of the box's side, as the time to cross it at the velocity limit [s]: first and largest.
_FIRST_BOX, _LARGEST_BOX = 0.1, 0.4
_SHRINK, _GROW = 0.4, 2.0
# Shares of the predicted decrease that must be achieved: to accept a step, not to shrink the box,
# to grow it.
_KEPT, _POOR, _GOOD = 0.1, 0.25, 0.7
# Least predicted decrease for a step, as a share of the duration.
_WORTHWHILE = 3e-4


class TrustRegion:
    """Trust-region iteration: a sequence of curves of decreasing cost.

    Attributes:
        seen: The current curve.
        num_steps: Number of steps tried.
    """

    def __init__(self, model: CurveModel, points: Float64[np.ndarray, "k nq"]) -> None:
        """Start at a curve, free or not."""
        self._model = model
        self._box = _FIRST_BOX
        self.seen: CurveEvaluation = model.look(points)
        self.num_steps = 0

    def run(self, most: int) -> Iterator[CurveEvaluation]:
        """Yield every better curve, the first one included, in at most `most` steps.

        Ends early where the model predicts no more decrease.
        """
        yield self.seen
        for _ in range(most):
            points, promised = self._model.step(self.seen, self._box)
            if promised < _WORTHWHILE * self.seen.duration:
                return
            self.num_steps += 1
            tried = self._model.look(points)
            kept = (self.seen.cost - tried.cost) / promised
            if kept < _POOR:
                self._box *= _SHRINK
            elif kept > _GOOD:
                self._box = min(self._box * _GROW, _LARGEST_BOX)
            if kept > _KEPT:
                self.seen = tried
                yield tried

    def keep_distance_at(
        self, instants: Float64[np.ndarray, " m"], free: CurveEvaluation | None
    ) -> None:
        """Add instants at which distances are kept, where the audit found the last curve too near.

        Return to a curve that was free, if there is one: at a thin wall that the last step crossed,
        gradients point to either side.
        """
        self._model.keep_distance_at(instants)
        self.seen = self._model.look((free or self.seen).points)
