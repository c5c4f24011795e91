"""FrameMotion: how a frame moves with a group, by the kernel if it can, else by Drake."""

from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.multibody.tree import JacobianWrtVariable

from planning.domain.joints import JointGroup
from planning.world.kernel_tree import kernel_chain
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]


class FrameMotion:
    """Poses and Jacobians of one frame; everything but the group is where the scene puts it."""

    def __init__(self, world: World, group: JointGroup, frame: str) -> None:
        """Prepare; the frame exists."""
        self._world, self._group, self._frame = world, group, frame
        self._chain = kernel_chain(world.drake, group, world.state, frame)

    def poses(
        self, qs: Float64[np.ndarray, "m nq"]
    ) -> tuple[Float64[np.ndarray, "m 3 3"], Float64[np.ndarray, "m 3"]]:
        """Return R_WF and p_WF [m] at each row."""
        if self._chain is not None:
            flat = np.asarray(self._chain.poses(np.ascontiguousarray(qs)))
            return flat[:, :9].reshape(-1, 3, 3), flat[:, 9:]
        x_wf = self._world.frame_poses(self._frame, self._world.embed(self._group, qs))
        return x_wf[:, :3, :3], x_wf[:, :3, 3]

    def jacobian(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "6 nv"]:
        """Return what the group's v does to the frame in world: angular, then its origin's."""
        if self._chain is not None:
            return np.asarray(self._chain.jacobians(np.ascontiguousarray(q[None])))[0]
        drake = self._world.drake
        context: Any = drake.plant.CreateDefaultContext()
        drake.plant.SetPositions(context, self._world.embed(self._group, q))
        world_frame = drake.plant.world_frame()
        full = drake.plant.CalcJacobianSpatialVelocity(
            context,
            JacobianWrtVariable.kV,
            drake.frames[self._frame],
            np.zeros(3),
            world_frame,
            world_frame,
        )
        for follower, leader, multiplier in reversed(drake.mimics):
            full[:, leader] += multiplier * full[:, follower]
        return full[:, drake.velocity_indices(self._group)]
