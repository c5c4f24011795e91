"""PredicateConstraint: a Python function of the caller as a compiled constraint."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.world.constraints.compiled_constraint import ConstraintValue


@dataclass(frozen=True)
class PredicateConstraint:
    """Constraint by a predicate, evaluated at samples.

    Attributes:
        label: For messages.
        predicate: Takes q, shape (nq,), and returns whether it is accepted.
        step: Largest distance between samples of an edge [rad or m].
    """

    label: str
    predicate: Callable[[Array], bool]
    step: float
    preferred_margin: float = 0.0

    def tightened(self, margin: float) -> "PredicateConstraint":
        """Return itself: a predicate has no signed margin."""
        del margin
        return self

    def value(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return 0 if accepted and 1 if not."""
        return ConstraintValue(0.0 if self.predicate(q) else 1.0, 0.0, "1")

    def are_satisfied(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return the predicate's result for each row."""
        return np.array([bool(self.predicate(q)) for q in qs], dtype=bool)
