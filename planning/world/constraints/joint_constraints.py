"""Joint constraints: joints locked at the start, or within tighter position bounds."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.domain.robot.manifold import Manifold
from planning.world.constraints.compiled_constraint import ROUNDING, ConstraintValue


@dataclass(frozen=True)
class LockConstraint:
    """Constraint: some velocity coordinates stay at the start.

    Attributes:
        label: For messages.
        manifold: Of the group.
        start: The group's q, shape (nq,).
        locked: Which coordinates of v, shape (nv,).
        names: Of the coordinates of v.
    """

    label: str
    manifold: Manifold
    start: Float64[np.ndarray, " nq"]
    locked: Bool[np.ndarray, " nv"]
    names: tuple[str, ...]
    preferred_margin: float = 0.0
    step: float = np.inf

    def tightened(self, margin: float) -> "LockConstraint":
        """Return itself: locked coordinates need no margin."""
        del margin
        return self

    def value(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return the largest distance of a locked coordinate from the start [rad or m]."""
        return _worst(self._distances_from_start(q[None])[0], self.names)

    def are_satisfied(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether all locked coordinates are at the start."""
        return self._distances_from_start(qs).max(axis=1) <= ROUNDING

    def _distances_from_start(self, qs: Array) -> Array:
        """Return the distance of every coordinate from its locked value, shape (m, nv)."""
        return np.abs(self.manifold.minus(qs, self.start)) * self.locked


@dataclass(frozen=True)
class LimitConstraint:
    """Constraint: every coordinate of q is within bounds; an angle on a circle modulo whole turns.

    Attributes:
        label: For messages.
        lower: Lower bounds, infinite where there is none [rad or m], shape (nq,).
        upper: Upper bounds, shape (nq,).
        is_circle: Which coordinates are angles on a circle, shape (nq,).
        names: Of the coordinates of q.
    """

    label: str
    lower: Float64[np.ndarray, " nq"]
    upper: Float64[np.ndarray, " nq"]
    is_circle: Bool[np.ndarray, " nq"]
    names: tuple[str, ...]
    preferred_margin: float = 0.0
    step: float = np.inf

    def tightened(self, margin: float) -> "LimitConstraint":
        """Return itself: bounds of coordinates hold along edges whose ends keep them."""
        del margin
        return self

    def value(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return the largest excess of a coordinate over its bounds [rad or m]."""
        return _worst(self._excess(q[None])[0], self.names)

    def are_satisfied(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether all bounds are kept."""
        return self._excess(qs).max(axis=1) <= ROUNDING

    def _excess(self, qs: Array) -> Array:
        """Return the excess of every coordinate over its bounds, shape (m, nq)."""
        wrapped = qs.copy()
        is_wrapped = self.is_circle & np.isfinite(self.lower)
        middle = (self.lower[is_wrapped] + self.upper[is_wrapped]) / 2
        wrapped[:, is_wrapped] = (
            middle + np.remainder(qs[:, is_wrapped] - middle + np.pi, 2 * np.pi) - np.pi
        )
        return np.maximum(self.lower - wrapped, wrapped - self.upper)


def _worst(amounts: Array, names: tuple[str, ...]) -> ConstraintValue:
    worst = int(np.argmax(amounts))
    return ConstraintValue(float(amounts[worst]), ROUNDING, "rad or m", names[worst])
