"""CompiledConstraint: one path constraint in one world, for one group, from one start."""

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float64

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Flags = np.ndarray[Any, np.dtype[np.bool_]]

# A violation up to this much is numeric dust [rad or m]; the certifier forgives the same.
DUST = 1e-6
# Samples of an edge are this far apart at least, however little room there is [rad or m].
FINEST = 2e-3


@dataclass(frozen=True)
class ConstraintValue:
    """How a configuration stands to a rule.

    Attributes:
        value: What was measured, in `unit`.
        bound: What it is held against.
        unit: "m", "rad", "rad or m" or "1".
        joint: The joint or coordinate that was measured; "" for rules that are not on joints.
    """

    value: float
    bound: float
    unit: str
    joint: str = ""


@runtime_checkable
class CompiledConstraint(Protocol):
    """What all rules can do.

    Attributes:
        label: For messages.
        step: Edges are looked at in samples no farther apart [rad or m].
        wish: How much room a search should leave, so that the certifier can prove the rule
            between samples, in the unit of the reading.
    """

    @property
    def label(self) -> str:
        """For messages."""
        ...

    @property
    def step(self) -> float:
        """Edges are looked at in samples no farther apart [rad or m]."""
        ...

    @property
    def wish(self) -> float:
        """How much room a search should leave, in the unit of the reading."""
        ...

    def leaving(self, room: float) -> "CompiledConstraint":
        """Return the rule that demands so much more than the constraint."""
        ...

    def reading(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return how q, shape (nq,), stands to the constraint itself."""
        ...

    def are_kept(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each row keeps the rule and leaves the room."""
        ...


def suggested_step(room: float) -> float:
    """Return how far samples may be apart that leave `room` on both sides."""
    return max(2 * room, FINEST)
