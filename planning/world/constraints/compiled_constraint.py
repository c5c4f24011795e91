"""CompiledConstraint: a path constraint resolved for one world, group and start."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float64

# Tolerance of a violation, for rounding [rad or m]; the certifier has the same.
ROUNDING = 1e-6
# Smallest distance between samples of an edge, for any margin [rad or m].
MIN_STEP = 2e-3


@dataclass(frozen=True)
class ConstraintValue:
    """Value of a constraint function at a configuration, with its bound.

    Attributes:
        value: The measured value, in `unit`.
        bound: The bound of the constraint, in `unit`.
        unit: "m", "rad", "rad or m" or "1".
        joint: The joint or coordinate that was measured; "" for constraints that are not on joints.
    """

    value: float
    bound: float
    unit: str
    joint: str = ""


@runtime_checkable
class CompiledConstraint(Protocol):
    """Protocol of all compiled constraints.

    Attributes:
        label: For messages.
        step: Largest distance between samples of an edge [rad or m].
        preferred_margin: Preferred margin of a search, so that the certifier can prove the
            constraint between samples, in the unit of `value`.
    """

    @property
    def label(self) -> str:
        """Name of the constraint in messages."""
        ...

    @property
    def step(self) -> float:
        """Largest distance between samples of an edge [rad or m]."""
        ...

    @property
    def preferred_margin(self) -> float:
        """Preferred margin of a search, in the unit of `value`."""
        ...

    def tightened(self, margin: float) -> "CompiledConstraint":
        """Return the constraint tightened by a margin."""
        ...

    def value(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return the constraint's value and bound at q, shape (nq,), without the margin."""
        ...

    def are_satisfied(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each row keeps the constraint with its margin."""
        ...


def suggested_step(margin: float) -> float:
    """Return the largest distance between samples that a margin `margin` allows [rad or m]."""
    return max(2 * margin, MIN_STEP)
