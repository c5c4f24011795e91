"""Pose: a rigid transform, `X_AB` in Drake's monogram notation."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry import rotation
from planning.domain.value import Value, frozen
from planning.errors import ProblemInvalid

_IDENTITY_ROTATION = frozen([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class Pose(Value):
    """Rigid transform X_AB: the pose of frame B in frame A.

    Attributes:
        position: p_AB [m].
        quaternion: R_AB as a unit quaternion `[w, x, y, z]` with w >= 0.
    """

    position: Float64[np.ndarray, "3"]
    quaternion: Float64[np.ndarray, "4"]

    @classmethod
    def identity(cls) -> "Pose":
        """Return the identity transform."""
        return cls(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))

    @classmethod
    def from_parts(
        cls, position: Any = (0, 0, 0), quaternion: Any = None, rpy: Any = None
    ) -> "Pose":
        """Build from a position [m] and a quaternion `[w, x, y, z]` or roll-pitch-yaw [rad].

        Raises:
            ProblemInvalid: Both rotations are given, a count is wrong, a number is not finite, or
                the quaternion is zero.
        """
        if quaternion is not None and rpy is not None:
            message = "a pose takes a quaternion or rpy, not both"
            raise ProblemInvalid(message, {"field": "rpy"})
        p = _vector("position", position, 3)
        if rpy is not None:
            return cls(p, rotation.from_rpy(_vector("rpy", rpy, 3)))
        if quaternion is None:
            return cls(p, _IDENTITY_ROTATION)
        a = _vector("quaternion", quaternion, 4)
        length = float(np.linalg.norm(a))
        if length < 1e-9:
            message = "quaternion [w, x, y, z] must not be zero"
            raise ProblemInvalid(message, {"field": "quaternion"})
        return cls(p, a / length if a[0] >= 0 else -a / length)

    @classmethod
    def from_matrix(cls, x: Float64[np.ndarray, "4 4"]) -> "Pose":
        """Build from a homogeneous transform."""
        return cls(x[:3, 3], rotation.from_matrix(x[:3, :3]))

    @property
    def matrix(self) -> Float64[np.ndarray, "4 4"]:
        """Homogeneous transform, shape (4, 4)."""
        x = np.eye(4)
        x[:3, :3] = rotation.matrix(self.quaternion)
        x[:3, 3] = self.position
        return x

    def __matmul__(self, other: "Pose") -> "Pose":
        """X_AB @ X_BC = X_AC."""
        a = rotation.multiply(self.quaternion, other.quaternion)
        p = self.position + rotation.rotate(self.quaternion, other.position)
        return Pose.from_parts(p, a)

    @property
    def inverse(self) -> "Pose":
        """X_BA."""
        a = rotation.conjugate(self.quaternion)
        return Pose(-rotation.rotate(a, self.position), a)

    def distance(self, other: "Pose") -> tuple[float, float]:
        """Return the distance of two poses: translation [m] and rotation angle [rad]."""
        rotation_vector = rotation.log(
            rotation.multiply(rotation.conjugate(self.quaternion), other.quaternion)
        )
        translation = float(np.linalg.norm(self.position - other.position))
        return translation, float(np.linalg.norm(rotation_vector))


def _vector(name: str, numbers: Any, count: int) -> Float64[np.ndarray, " n"]:
    try:
        vector = frozen(numbers)
    except (TypeError, ValueError) as fault:
        message = f"{name} must be {count} numbers, got {numbers!r}"
        raise ProblemInvalid(message, {"field": name}) from fault
    if vector.shape != (count,) or not np.isfinite(vector).all():
        message = f"{name} must be {count} finite numbers, got {numbers!r}"
        raise ProblemInvalid(message, {"field": name})
    return vector
