"""ConeConstraint: an axis of a frame within an angle of a direction."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.world.constraints.compiled_constraint import ROUNDING, ConstraintValue, suggested_step
from planning.world.mechanics.tool_kinematics import ToolKinematics

# Preferred margin: this share of the tolerance, and no more than this [rad].
_MARGIN_FRACTION, _MAX_MARGIN = 0.1, 0.02
# Angle below which random samples miss a cone [rad].
_MAX_NARROW_ANGLE = 1.0
# Sine of the angle below which axis and direction are parallel: the rotation axis is undefined.
_DEGENERATE = 1e-9


@dataclass(frozen=True)
class ConeConstraint:
    """Constraint: the angle between R_WF a and d is at most a tolerance.

    Attributes:
        label: For messages.
        kinematics: Kinematics of the frame F.
        axis: a, a unit vector, shape (3,).
        direction: d in world, a unit vector, shape (3,).
        tolerance: [rad].
        margin: Margin in addition to the constraint [rad].
    """

    label: str
    kinematics: ToolKinematics
    axis: Float64[np.ndarray, "3"]
    direction: Float64[np.ndarray, "3"]
    tolerance: float
    margin: float = 0.0

    @property
    def preferred_margin(self) -> float:
        """Preferred margin of a search [rad]."""
        return min(_MARGIN_FRACTION * self.tolerance, _MAX_MARGIN)

    @property
    def step(self) -> float:
        """Largest distance between samples of an edge [rad or m]."""
        return suggested_step(self.margin)

    @property
    def is_thin(self) -> bool:
        """Whether the cone is too narrow to be sampled: samples must be projected onto it."""
        return self.tolerance < _MAX_NARROW_ANGLE

    def tightened(self, margin: float) -> "ConeConstraint":
        """Return the constraint tightened by a margin [rad]."""
        return replace(self, margin=margin)

    def value(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return the angle [rad]."""
        angle = float(self._angles(self._axes(q[None]))[0])
        return ConstraintValue(angle, self.tolerance, "rad")

    def are_satisfied(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each row's angle is within the tolerance less the margin `margin`."""
        return self.signed_margins(qs) >= self.margin - ROUNDING

    def signed_margins(self, qs: Float64[np.ndarray, "m nq"]) -> Float64[np.ndarray, " m"]:
        """Return the signed margin of each row: tolerance less angle [rad]."""
        return self.tolerance - self._angles(self._axes(qs))

    def residual(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "1"]:
        """Return the excess of the angle over the tolerance less twice the margin [rad]."""
        return np.maximum(self._angles(self._axes(q[None])) - self.tolerance + 2 * self.margin, 0.0)

    def jacobian(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "1 nv"]:
        """Return the derivative of `residual`: d angle = (d x a) . omega / |d x a|."""
        rotation_jacobian = self.kinematics.velocity_jacobians(q[None])[0, :3]
        normal = self._cross @ self._axes(q[None])[0]
        sine = float(np.sqrt(normal @ normal))
        if sine < _DEGENERATE or not self.residual(q)[0] > 0:
            return np.zeros((1, rotation_jacobian.shape[1]))
        return (normal / sine)[None] @ rotation_jacobian

    @cached_property
    def _cross(self) -> Array:
        """Cross product matrix of d, shape (3, 3): `np.cross` is slow."""
        x, y, z = self.direction
        return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])

    def _axes(self, qs: Array) -> Array:
        return self.kinematics.poses(qs)[0] @ self.axis

    def _angles(self, axes: Array) -> Array:
        normals = axes @ self._cross.T
        return np.arctan2(np.sqrt((normals * normals).sum(axis=1)), axes @ self.direction)
