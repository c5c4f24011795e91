"""OffsetFrame: one of Drake's frames, or a frame at a constant offset from one."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Frame, JacobianWrtVariable


@dataclass(frozen=True, eq=False)
class OffsetFrame:
    """Frame T of a scene: fixed to a frame F of Drake's plant.

    Frames of objects outside of Drake's model are at an offset from the world; all others are
    Drake's own, without one.

    Attributes:
        frame: F.
        X_FT: Pose of T in F; None for the identity.
    """

    frame: Frame
    X_FT: RigidTransform | None = None

    @property
    def body(self) -> BodyIndex:
        """Index of the body that it is fixed to."""
        return self.frame.body().index()

    @property
    def origin(self) -> Float64[np.ndarray, "3"]:
        """p_FT, its origin in F [m]."""
        return np.zeros(3) if self.X_FT is None else np.array(self.X_FT.translation())

    @property
    def rotation(self) -> Float64[np.ndarray, "3 3"]:
        """R_FT."""
        return np.eye(3) if self.X_FT is None else self.X_FT.rotation().matrix()

    @property
    def pose_in_body(self) -> RigidTransform:
        """X_BT, its pose in the body that it is fixed to."""
        return self._offset_from(self.frame.GetFixedPoseInBodyFrame())

    def pose(self, context: Any) -> RigidTransform:
        """Return X_WT at the state of the plant's context."""
        return self._offset_from(self.frame.CalcPoseInWorld(context))

    def velocity_jacobian(
        self, plant: MultibodyPlant, context: Any
    ) -> Float64[np.ndarray, "6 num_velocities"]:
        """Return the Jacobian of V_WT, angular first, by Drake's velocities."""
        of_v, world = JacobianWrtVariable.kV, plant.world_frame()
        return plant.CalcJacobianSpatialVelocity(
            context, of_v, self.frame, self.origin, world, world
        )

    def _offset_from(self, x: RigidTransform) -> RigidTransform:
        return x if self.X_FT is None else x.multiply(self.X_FT)
