"""Descent: one local optimization of a curve from a guess."""

from typing import Protocol, runtime_checkable

import numpy as np

from planning.domain.arrays import Array
from planning.refine.curves.curve_evaluation import CurveEvaluation
from planning.refine.descents.trust_region import TrustRegion
from planning.refine.model.curve_model import CurveModel

# Iterations, not seconds, decide when to give up, so that the same request gives the same bytes.
MAX_STEPS = 22
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
        is_finished: Whether it cannot go on.
    """

    def __init__(self, problem: CurveChecker, model: CurveModel, guess: Array) -> None:
        """Evaluate the guess; nothing is audited yet."""
        self._problem = problem
        self._model = model
        self._trust_region = TrustRegion(model, model.evaluate(guess))
        self._curves = self._trust_region.run(MAX_STEPS)
        self._merits: list[float] = []
        self._num_rejected = 0
        self.best: CurveEvaluation | None = None
        self.is_finished = False
        self.reason = "the deadline passed during refinement"

    @property
    def num_steps(self) -> int:
        """Number of trust-region steps so far."""
        return self._trust_region.num_steps

    @property
    def merit(self) -> float:
        """Merit of the current curve, free or not [s]."""
        return self._trust_region.current.merit

    @property
    def points(self) -> Array:
        """Control points of the best free curve, or of the current one if there is none."""
        return (self.best or self._trust_region.current).points

    def advance(
        self,
        to_beat: float = np.inf,
        max_steps: int = MAX_STEPS,
        num_foreseen: int = MAX_STEPS,
    ) -> None:
        """Go on until the descent is finished, or has taken a number of steps.

        Args:
            to_beat: Objective of another curve; a descent that does not get below that at its
                present rate stops.
            max_steps: Number of steps, those before included, after which the next better curve is
                the last.
            num_foreseen: Largest number of steps for which it is taken to keep that rate.
        """
        while not (self.is_finished or self.num_steps >= max_steps):
            if self._foreseen_merit(num_foreseen) > to_beat:
                return
            evaluation = next(self._curves, None)
            self.is_finished = (
                evaluation is None or self._accepts_no_more(evaluation) or self._problem.is_over
            )

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

    def _foreseen_merit(self, num_foreseen: int) -> float:
        """Return the merit to which the last curves, continued in a line, lead within steps."""
        if len(self._merits) <= _NUM_RATE_CURVES:
            return -np.inf
        per_curve = (self._merits[-1 - _NUM_RATE_CURVES] - self._merits[-1]) / _NUM_RATE_CURVES
        per_step = per_curve * len(self._merits) / max(1, self.num_steps)
        return self._merits[-1] - per_step * min(num_foreseen, MAX_STEPS - self.num_steps)
