"""BoxConstraint: the origin of a frame in a box, or out of it."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.world.constraints.compiled_constraint import DUST, ConstraintValue, suggested_step
from planning.world.mechanics.tool_kinematics import ToolKinematics

type Array = np.ndarray[Any, np.dtype[np.float64]]

# The room to leave: this share of the thinnest side, and no more than this [m].
_SHARE, _MOST = 0.1, 4e-3
# A box thinner than this is not found by sampling [m].
_THIN = 0.2


@dataclass(frozen=True)
class BoxConstraint:
    """A box B in world; spare is how far the origin is from the faces, on the right side.

    Attributes:
        label: For messages.
        motion: Of the frame.
        pose: X_WB.
        half: Half side lengths, infinite where there are none [m], shape (3,).
        is_inside: Whether to stay in or out.
        room: Demanded beyond the constraint [m].
    """

    label: str
    motion: ToolKinematics
    pose: Pose
    half: Float64[np.ndarray, "3"]
    is_inside: bool
    room: float = 0.0

    @property
    def wish(self) -> float:
        """How much room a search should leave [m]."""
        return min(_SHARE * float(self.half.min()), _MOST) if self.is_inside else _MOST / 2

    @property
    def step(self) -> float:
        """Edges are looked at in samples no farther apart [rad or m]."""
        return suggested_step(self.room)

    @property
    def is_thin(self) -> bool:
        """Whether samples must be projected onto it."""
        return self.is_inside and float(self.half.min()) < _THIN / 2

    def leaving(self, room: float) -> "BoxConstraint":
        """Return the rule that demands so much more [m]."""
        return replace(self, room=room)

    def reading(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return the signed distance [m] beyond the faces, or inside them for `keep_out`."""
        return ConstraintValue(-float(self.spares(q[None])[0]), 0.0, "m")

    def are_kept(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each row is on the right side and leaves the room."""
        return self.spares(qs) >= self.room - DUST

    def residual(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "3"]:
        """Return by how much the origin misses the box, less the room, along its axes [m]."""
        local = self.local(q[None])[0]
        return np.sign(local) * np.maximum(np.abs(local) - (self.half - 2 * self.room), 0.0)

    def jacobian(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "3 nv"]:
        """Return the derivative of `residual`."""
        moves = self._rotation.T @ self.motion.by_v(q[None])[0, 3:]
        return np.where(self.residual(q)[:, None] != 0, moves, 0.0)

    @cached_property
    def _rotation(self) -> Array:
        return rotation.matrix(self.pose.quaternion)

    def local(self, qs: Float64[np.ndarray, "m nq"]) -> Float64[np.ndarray, "m 3"]:
        """Return where each row's origin is in the box's axes, from its middle [m]."""
        return (self.motion.poses(qs)[1] - self.pose.position) @ self._rotation

    def spares(self, qs: Float64[np.ndarray, "m nq"]) -> Float64[np.ndarray, " m"]:
        """Return how far each row's origin is from the faces, on the right side [m]."""
        beyond = np.abs(self.local(qs)) - self.half
        worst = beyond.max(axis=1)
        if self.is_inside:
            return -worst
        outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
        return np.where(worst > 0, outside, worst)
