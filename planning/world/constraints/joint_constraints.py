"""Rules on joints: locked where the start has them, or within tighter bounds."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.robot.manifold import Manifold
from planning.world.constraints.compiled_constraint import DUST, ConstraintValue

type Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class LockConstraint:
    """Some velocity coordinates do not leave the start.

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
    wish: float = 0.0
    step: float = np.inf

    def leaving(self, room: float) -> "LockConstraint":
        """Return itself: what does not move needs no room."""
        del room
        return self

    def reading(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return how far the farthest of them is from the start [rad or m]."""
        return _worst(self._away(q[None])[0], self.names)

    def are_kept(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether they are where the start has them."""
        return self._away(qs).max(axis=1) <= DUST

    def _away(self, qs: Array) -> Array:
        """Return how far every coordinate is from where it is locked, shape (m, nv)."""
        return np.abs(self.manifold.minus(qs, self.start)) * self.locked


@dataclass(frozen=True)
class LimitConstraint:
    """Every coordinate of q keeps its bounds; an angle on a circle may be whole turns off.

    Attributes:
        label: For messages.
        lower: Infinite where there is none [rad or m], shape (nq,).
        upper: And above, shape (nq,).
        is_circle: Which coordinates are angles on a circle, shape (nq,).
        names: Of the coordinates of q.
    """

    label: str
    lower: Float64[np.ndarray, " nq"]
    upper: Float64[np.ndarray, " nq"]
    is_circle: Bool[np.ndarray, " nq"]
    names: tuple[str, ...]
    wish: float = 0.0
    step: float = np.inf

    def leaving(self, room: float) -> "LimitConstraint":
        """Return itself: bounds of coordinates hold along edges whose ends keep them."""
        del room
        return self

    def reading(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return by how much a coordinate leaves its bounds at most [rad or m]."""
        return _worst(self._excess(q[None])[0], self.names)

    def are_kept(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether all bounds are kept."""
        return self._excess(qs).max(axis=1) <= DUST

    def _excess(self, qs: Array) -> Array:
        """Return by how much every coordinate leaves its bounds, shape (m, nq)."""
        at = qs.copy()
        turning = self.is_circle & np.isfinite(self.lower)
        middle = (self.lower[turning] + self.upper[turning]) / 2
        at[:, turning] = middle + np.remainder(qs[:, turning] - middle + np.pi, 2 * np.pi) - np.pi
        return np.maximum(self.lower - at, at - self.upper)


def _worst(amounts: Array, names: tuple[str, ...]) -> ConstraintValue:
    worst = int(np.argmax(amounts))
    return ConstraintValue(float(amounts[worst]), DUST, "rad or m", names[worst])
