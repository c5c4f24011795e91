"""BoxConstraint: the origin of a frame inside a box (keep in) or outside of it (keep out)."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.world.constraints.compiled_constraint import ROUNDING, ConstraintValue, suggested_step
from planning.world.mechanics.tool_kinematics import ToolKinematics

# Preferred margin: this share of the thinnest side, and no more than this [m].
_MARGIN_FRACTION, _MAX_MARGIN = 0.1, 4e-3
# Thickness below which random samples miss a box [m].
_MAX_THIN_WIDTH = 0.2


@dataclass(frozen=True)
class BoxConstraint:
    """Constraint by a box B in world; its signed margin is the origin's distance from the faces.

    Attributes:
        label: For messages.
        kinematics: Kinematics of the frame.
        pose: X_WB.
        half: Half side lengths, infinite along unbounded axes [m], shape (3,).
        is_inside: Whether the origin stays inside, or outside.
        margin: Margin in addition to the constraint [m].
    """

    label: str
    kinematics: ToolKinematics
    pose: Pose
    half: Float64[np.ndarray, "3"]
    is_inside: bool
    margin: float = 0.0

    @property
    def preferred_margin(self) -> float:
        """Preferred margin of a search [m]."""
        return (
            min(_MARGIN_FRACTION * float(self.half.min()), _MAX_MARGIN)
            if self.is_inside
            else _MAX_MARGIN / 2
        )

    @property
    def step(self) -> float:
        """Largest distance between samples of an edge [rad or m]."""
        return suggested_step(self.margin)

    @property
    def is_thin(self) -> bool:
        """Whether the box is too thin to be sampled, so that samples must be projected onto it."""
        return self.is_inside and float(self.half.min()) < _MAX_THIN_WIDTH / 2

    def tightened(self, margin: float) -> "BoxConstraint":
        """Return the constraint tightened by a margin [m]."""
        return replace(self, margin=margin)

    def value(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return the signed distance [m] beyond the faces, or inside them for `keep_out`."""
        return ConstraintValue(-float(self.signed_margins(q[None])[0]), 0.0, "m")

    def are_satisfied(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each row is on the right side with the margin `margin`."""
        return self.signed_margins(qs) >= self.margin - ROUNDING

    def residual(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "3"]:
        """Return the origin's excess over the box shrunk by twice `margin`, along its axes [m]."""
        local = self.origins_in_box(q[None])[0]
        return np.sign(local) * np.maximum(np.abs(local) - (self.half - 2 * self.margin), 0.0)

    def jacobian(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "3 nv"]:
        """Return the derivative of `residual`."""
        position_jacobian = self._rotation.T @ self.kinematics.velocity_jacobians(q[None])[0, 3:]
        return np.where(self.residual(q)[:, None] != 0, position_jacobian, 0.0)

    @cached_property
    def _rotation(self) -> Array:
        return rotation.matrix(self.pose.quaternion)

    def origins_in_box(self, qs: Float64[np.ndarray, "m nq"]) -> Float64[np.ndarray, "m 3"]:
        """Return each row's origin in the box frame B [m]."""
        return (self.kinematics.poses(qs)[1] - self.pose.position) @ self._rotation

    def margin_gradients(self, qs: Float64[np.ndarray, "m nq"]) -> Float64[np.ndarray, "m 3"]:
        """Return the derivatives of `signed_margins` by the origin's position in W, to keep out.

        Where the nearest face changes, of one of them.
        """
        return self.gradients_at(self.origins_in_box(qs))

    def gradients_at(self, local: Float64[np.ndarray, "m 3"]) -> Float64[np.ndarray, "m 3"]:
        """Return `margin_gradients` for origins in the box frame B."""
        excess = np.abs(local) - self.half
        outside = np.maximum(excess, 0.0)
        lengths = np.linalg.norm(outside, axis=1, keepdims=True)
        nearest = np.eye(3)[np.argmax(excess, axis=1)]
        normals = np.where(lengths > 0, outside / np.where(lengths > 0, lengths, 1.0), nearest)
        return (normals * np.where(local < 0, -1.0, 1.0)) @ self._rotation.T

    def signed_margins(self, qs: Float64[np.ndarray, "m nq"]) -> Float64[np.ndarray, " m"]:
        """Return the signed margin of each row: distance from the faces, positive if kept [m]."""
        return self.margins_at(self.origins_in_box(qs))

    def margins_at(self, local: Float64[np.ndarray, "m 3"]) -> Float64[np.ndarray, " m"]:
        """Return `signed_margins` for origins in the box frame B [m]."""
        excess = np.abs(local) - self.half
        worst = excess.max(axis=1)
        if self.is_inside:
            return -worst
        outside = np.linalg.norm(np.maximum(excess, 0.0), axis=1)
        return np.where(worst > 0, outside, worst)
