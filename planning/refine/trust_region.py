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
_INITIAL_RADIUS, _MAX_RADIUS = 0.1, 0.4
_SHRINK_FACTOR, _GROW_FACTOR = 0.4, 2.0
# Shares of the predicted decrease that must be achieved: to accept a step, not to shrink the box,
# to grow it.
_ACCEPT_RATIO, _SHRINK_RATIO, _GROW_RATIO = 0.1, 0.25, 0.7
# Least predicted decrease for a step, as a share of the duration.
_MIN_PREDICTED_DECREASE = 3e-4


class TrustRegion:
    """Trust-region iteration: a sequence of curves of decreasing cost.

    Attributes:
        current: The current curve.
        num_steps: Number of steps tried.
    """

    def __init__(self, model: CurveModel, points: Float64[np.ndarray, "k nq"]) -> None:
        """Start at a curve, free or not."""
        self._model = model
        self._radius = _INITIAL_RADIUS
        self.current: CurveEvaluation = model.evaluate(points)
        self.num_steps = 0

    def run(self, max_steps: int) -> Iterator[CurveEvaluation]:
        """Yield every better curve, the first one included, in at most `max_steps` steps.

        Ends early where the model predicts no more decrease.
        """
        yield self.current
        for _ in range(max_steps):
            points, predicted_decrease = self._model.step(self.current, self._radius)
            if predicted_decrease < _MIN_PREDICTED_DECREASE * self.current.duration:
                return
            self.num_steps += 1
            trial = self._model.evaluate(points)
            ratio = (self.current.merit - trial.merit) / predicted_decrease
            if ratio < _SHRINK_RATIO:
                self._radius *= _SHRINK_FACTOR
            elif ratio > _GROW_RATIO:
                self._radius = min(self._radius * _GROW_FACTOR, _MAX_RADIUS)
            if ratio > _ACCEPT_RATIO:
                self.current = trial
                yield trial

    def add_samples(
        self, parameters: Float64[np.ndarray, " m"], free: CurveEvaluation | None
    ) -> None:
        """Add instants at which distances are kept, where the audit found violations.

        Return to a curve that was free, if there is one: at a thin wall that the last step crossed,
        gradients point to either side.
        """
        self._model.add_samples(parameters)
        self.current = self._model.evaluate((free or self.current).points)
