"""ConeConstraint: an axis of a frame within an angle of a direction."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.world.constraints.compiled_constraint import DUST, ConstraintValue, suggested_step
from planning.world.mechanics.tool_kinematics import ToolKinematics

# Preferred margin: this share of the tolerance, and no more than this [rad].
_SHARE, _MOST = 0.1, 0.02
# Angle below which random samples miss a cone [rad].
_NARROW = 1.0
# Sine of the angle below which axis and direction are parallel: any rotation axis will do there.
_DEGENERATE = 1e-9


@dataclass(frozen=True)
class ConeConstraint:
    """Constraint: the angle between R_WF a and d is at most a tolerance.

    Attributes:
        label: For messages.
        motion: Kinematics of the frame F.
        axis: a, a unit vector, shape (3,).
        direction: d in world, a unit vector, shape (3,).
        tolerance: [rad].
        room: Margin in addition to the constraint [rad].
    """

    label: str
    motion: ToolKinematics
    axis: Float64[np.ndarray, "3"]
    direction: Float64[np.ndarray, "3"]
    tolerance: float
    room: float = 0.0

    @property
    def wish(self) -> float:
        """Preferred margin of a search [rad]."""
        return min(_SHARE * self.tolerance, _MOST)

    @property
    def step(self) -> float:
        """Largest distance between samples of an edge [rad or m]."""
        return suggested_step(self.room)

    @property
    def is_thin(self) -> bool:
        """Whether the cone is too narrow to be sampled: samples must be projected onto it."""
        return self.tolerance < _NARROW

    def leaving(self, room: float) -> "ConeConstraint":
        """Return the constraint tightened by a margin [rad]."""
        return replace(self, room=room)

    def reading(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return the angle [rad]."""
        angle = float(self._angles(self._axes(q[None]))[0])
        return ConstraintValue(angle, self.tolerance, "rad")

    def are_kept(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each row's angle is within the tolerance less the margin `room`."""
        return self.spares(qs) >= self.room - DUST

    def spares(self, qs: Float64[np.ndarray, "m nq"]) -> Float64[np.ndarray, " m"]:
        """Return the signed margin of each row: tolerance less angle [rad]."""
        return self.tolerance - self._angles(self._axes(qs))

    def residual(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "1"]:
        """Return the excess of the angle over the tolerance less twice the margin [rad]."""
        return np.maximum(self._angles(self._axes(q[None])) - self.tolerance + 2 * self.room, 0.0)

    def jacobian(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "1 nv"]:
        """Return the derivative of `residual`: d angle = (d x a) . omega / |d x a|."""
        turns = self.motion.by_v(q[None])[0, :3]
        across = self._cross @ self._axes(q[None])[0]
        sine = float(np.sqrt(across @ across))
        if sine < _DEGENERATE or not self.residual(q)[0] > 0:
            return np.zeros((1, turns.shape[1]))
        return (across / sine)[None] @ turns

    @cached_property
    def _cross(self) -> Array:
        """Cross product matrix of d, shape (3, 3): `np.cross` is slow."""
        x, y, z = self.direction
        return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])

    def _axes(self, qs: Array) -> Array:
        return self.motion.poses(qs)[0] @ self.axis

    def _angles(self, axes: Array) -> Array:
        across = axes @ self._cross.T
        return np.arctan2(np.sqrt((across * across).sum(axis=1)), axes @ self.direction)
