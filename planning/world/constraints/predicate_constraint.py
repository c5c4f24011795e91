"""PredicateConstraint: a function of the user's says yes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.world.constraints.compiled_constraint import ConstraintValue

type Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class PredicateConstraint:
    """What a predicate says of samples.

    Attributes:
        label: For messages.
        predicate: Takes q, shape (nq,).
        step: Edges are looked at in samples no farther apart [rad or m].
    """

    label: str
    predicate: Callable[[Array], bool]
    step: float
    wish: float = 0.0

    def leaving(self, room: float) -> "PredicateConstraint":
        """Return itself: nothing is known of how near it is to a no."""
        del room
        return self

    def reading(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return 0 for yes and 1 for no."""
        return ConstraintValue(0.0 if self.predicate(q) else 1.0, 0.0, "1")

    def are_kept(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return its answer for each row."""
        return np.array([bool(self.predicate(q)) for q in qs], dtype=bool)
