"""Steps towards quicker curves: the model's best within a box, which grows and shrinks by merit."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64

from planning.refine.curves.curve_evaluation import CurveEvaluation
from planning.refine.model.curve_model import CurveModel

# Half of the box's sides, as the time to cross it at the velocity limit [s].
_FIRST_BOX, _LARGEST_BOX = 0.1, 0.4
_SHRINK, _GROW = 0.4, 2.0
# Of what the model promised, what must be kept for a step to count, not to shrink, to grow.
_KEPT, _POOR, _GOOD = 0.1, 0.25, 0.7
# A promise of less than this share of the duration is not worth a step.
_WORTHWHILE = 3e-4


class TrustRegion:
    """One curve after another, each of less cost than the one before.

    Attributes:
        seen: The curve so far.
        num_steps: How many steps were tried.
    """

    def __init__(self, model: CurveModel, points: Float64[np.ndarray, "k nq"]) -> None:
        """Start at a curve, free or not."""
        self._model = model
        self._box = _FIRST_BOX
        self.seen: CurveEvaluation = model.look(points)
        self.num_steps = 0

    def run(self, most: int) -> Iterator[CurveEvaluation]:
        """Yield every curve that is better, the first included, after at most so many steps.

        Ends early where the model promises nothing any more.
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
        """Demand distances at more instants, where the last curve has turned out to be too near.

        Go back to a curve that was free, if there is one: a thin wall that the last step jumped
        into or through pushes to either side.
        """
        self._model.keep_distance_at(instants)
        self.seen = self._model.look((free or self.seen).points)
