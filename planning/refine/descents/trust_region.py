"""TrustRegion: steps of a sequential convex program within a box that grows and shrinks by merit.

The box around the variables grows where the convex model predicts the decrease of the cost well,
and shrinks where it does not (Nocedal and Wright, "Numerical Optimization", 2006, ch. 4).
"""

from collections.abc import Iterator
from typing import Protocol

# Half of the box's side, as the time to cross it at the velocity limit [s]: first and largest.
_INITIAL_RADIUS, _MAX_RADIUS = 0.1, 0.4
_SHRINK_FACTOR, _GROW_FACTOR = 0.4, 1.5
# Shares of the predicted decrease that must be achieved: to accept a step, not to shrink the box,
# to grow it.
_ACCEPT_RATIO, _SHRINK_RATIO, _GROW_RATIO = 0.1, 0.25, 0.7
# Least predicted decrease for a step, as a share of the merit's scale.
_MIN_PREDICTED_DECREASE = 3e-4


class Evaluation(Protocol):
    """What a model says of one iterate."""

    @property
    def merit(self) -> float:
        """What the iteration minimizes: the cost, and penalties of constraints."""
        ...

    @property
    def merit_scale(self) -> float:
        """A typical size of the cost, in the same unit."""
        ...


class StepModel[X, E: Evaluation](Protocol):
    """A cost with penalties, and its convex model around an iterate X."""

    def evaluate(self, points: X, /) -> E:
        """Return the evaluation of an iterate."""
        ...

    def evaluate_trial(self, points: X, current: E, merit: float, /) -> E | None:
        """Return the evaluation of a step from `current`, or None if its merit is above `merit`."""
        ...

    def step(self, evaluation: E, radius: float, /) -> tuple[X, float]:
        """Return the model's minimizer in a box, and the predicted decrease of the merit."""
        ...


class TrustRegion[X, E: Evaluation]:
    """Trust-region iteration: a sequence of evaluations of decreasing merit.

    Attributes:
        current: The current iterate; another one may be set between steps.
        num_steps: Number of steps tried.
    """

    def __init__(self, model: StepModel[X, E], first: E) -> None:
        """Start at an iterate, free or not."""
        self._model = model
        self._radius = _INITIAL_RADIUS
        self.current = first
        self.num_steps = 0

    def run(self, max_steps: int) -> Iterator[E]:
        """Yield every better iterate, the first one included, in at most `max_steps` steps.

        Ends early where the model predicts no more decrease.
        """
        yield self.current
        for _ in range(max_steps):
            points, predicted_decrease = self._model.step(self.current, self._radius)
            if predicted_decrease < _MIN_PREDICTED_DECREASE * self.current.merit_scale:
                return
            self.num_steps += 1
            worst = self.current.merit - _ACCEPT_RATIO * predicted_decrease
            trial = self._model.evaluate_trial(points, self.current, worst)
            if trial is None:
                self._radius *= _SHRINK_FACTOR
                continue
            ratio = (self.current.merit - trial.merit) / predicted_decrease
            if ratio < _SHRINK_RATIO:
                self._radius *= _SHRINK_FACTOR
            elif ratio > _GROW_RATIO:
                self._radius = min(self._radius * _GROW_FACTOR, _MAX_RADIUS)
            if ratio > _ACCEPT_RATIO:
                self.current = trial
                yield trial
