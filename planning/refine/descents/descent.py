"""Descent: one local optimization of a curve from a guess."""

from typing import Protocol, runtime_checkable

import numpy as np

from planning.domain.arrays import Array
from planning.refine.curves.curve_evaluation import CurveEvaluation
from planning.refine.descents.trust_region import TrustRegion
from planning.refine.model.curve_model import CurveModel

# Iterations, not seconds, decide when to give up, so that the same request gives the same bytes.
MAX_STEPS = 25
# Number of better curves over which the rate of a descent is taken.
_NUM_RATE_CURVES = 3
# Factor above the least possible duration at which a descent stops.
_STOP_RATIO = 1.002
# Number of curves rejected by a predicate that ends a descent: no gradient leads to others.
_MAX_REJECTED_CURVES = 2
PREDICATE_REJECTION = "the optimized curve violates a path predicate"


@runtime_checkable
class CurveChecker(Protocol):
    """What a descent asks of its problem."""

    @property
    def lower_bound(self) -> float:
        """Lower bound of the duration of all motions from start to goal [s]."""
        ...

    @property
    def is_over(self) -> bool:
        """Whether the time is used up."""
        ...

    def check_curve(self, evaluation: CurveEvaluation, /) -> tuple[str, Array]:
        """Return why a curve is rejected, or "", and the instants where it is in violation."""
        ...


class Descent:
    """A trust-region iteration, every better curve of which is audited.

    Attributes:
        best: Best free curve so far, or None.
        reason: Why the last curve was rejected, or "".
    """

    def __init__(self, problem: CurveChecker, model: CurveModel, guess: Array) -> None:
        """Evaluate the guess; nothing is audited yet."""
        self._problem = problem
        self._model = model
        self._trust_region = TrustRegion(model, model.evaluate(guess))
        self._merits: list[float] = []
        self._num_rejected = 0
        self.best: CurveEvaluation | None = None
        self.reason = "the deadline passed during refinement"

    @property
    def num_steps(self) -> int:
        """Number of trust-region steps so far."""
        return self._trust_region.num_steps

    def advance(self, to_beat: float = np.inf) -> None:
        """Go on until the descent is finished.

        Args:
            to_beat: Objective of another curve; a descent that goes on to the last step at its
                present rate, and is still above that, is finished.
        """
        for evaluation in self._trust_region.run(MAX_STEPS):
            if (
                self._accepts_no_more(evaluation)
                or self._problem.is_over
                or self._is_hopeless(to_beat)
            ):
                return

    def _accepts_no_more(self, evaluation: CurveEvaluation) -> bool:
        """Audit a better curve, and return whether the descent ends with it."""
        self._merits.append(evaluation.merit)
        if self.best is None or evaluation.objective < self.best.objective:
            self.reason, violations = self._problem.check_curve(evaluation)
            self._num_rejected += self.reason == PREDICATE_REJECTION
            if not self.reason:
                self.best = evaluation
            if len(violations):
                # At a thin wall that the last step crossed, gradients point to either side: back
                # to a curve that was free, if there is one.
                self._model.add_samples(violations)
                known = self.best or self._trust_region.current
                self._trust_region.current = self._model.evaluate_again(known)
        target = _STOP_RATIO * self._problem.lower_bound
        is_optimal = self.best is not None and self.best.objective < target
        return is_optimal or self._num_rejected >= _MAX_REJECTED_CURVES

    def _is_hopeless(self, to_beat: float) -> bool:
        """Return whether the last curves, continued in a line, do not get below an objective."""
        if len(self._merits) <= _NUM_RATE_CURVES:
            return False
        per_curve = (self._merits[-1 - _NUM_RATE_CURVES] - self._merits[-1]) / _NUM_RATE_CURVES
        per_step = per_curve * len(self._merits) / max(1, self.num_steps)
        return self._merits[-1] - per_step * (MAX_STEPS - self.num_steps) > to_beat
