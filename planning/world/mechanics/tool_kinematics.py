"""ToolKinematics: poses and Jacobians of one frame for many configurations of a group."""

from functools import cached_property

import numpy as np
from jaxtyping import Float64, Int64
from pydrake.multibody.tree import JointIndex
from pydrake.systems.framework import Context

from planning.domain.arrays import Array, Indices
from planning.domain.geometry import rotation
from planning.domain.robot.joints import JointGroup, JointType
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_tree import kernel_chain
from planning.world.world import World


class ToolKinematics:
    """Forward kinematics of a tool frame by the native kernel, else by Drake; other joints stay.

    Attributes:
        frame: Full name of T.
    """

    def __init__(self, world: World, group: JointGroup, frame: str) -> None:
        """Prepare for one frame.

        Raises:
            UnknownName: There is no such frame.
        """
        world.validate_frame(frame)
        self._world, self._group, self.frame = world, group, frame
        self._chain = kernel_chain(world.drake, group, world.state, frame)
        self._floating_offsets = _floating_offsets(group)

    def poses(
        self, qs: Float64[np.ndarray, "n nq"]
    ) -> tuple[Float64[np.ndarray, "n 3 3"], Float64[np.ndarray, "n 3"]]:
        """Return R_WT and p_WT [m]."""
        if self._chain is None:
            full = self._world.embed(self._group, qs)
            x = self._world.frame_poses(self.frame, full)
            return np.ascontiguousarray(x[:, :3, :3]), np.ascontiguousarray(x[:, :3, 3])
        x = self._chain.poses(np.ascontiguousarray(qs))
        return x[:, :9].reshape(-1, 3, 3), x[:, 9:]

    def jacobians(self, qs: Float64[np.ndarray, "n nq"]) -> Float64[np.ndarray, "n 6 nv"]:
        """Return Jacobians of T in W (rotation; translation) by the tangent, with followers.

        Columns of joints that turn and shift in the tangent's own axes (floating ones) differ from
        Drake's, whose angular velocity is in the parent's axes.
        """
        return self._to_tangent(qs, self.velocity_jacobians(qs))

    def jacobians_with_followers(
        self, qs: Float64[np.ndarray, "n nq"]
    ) -> Float64[np.ndarray, "n 6 k"]:
        """Return the Jacobians' columns by the tangent, followers apart from their leaders.

        First come the group's own, as `jacobians` has them without followers, then those of
        `followers`. Bounds need them: where a follower turns against its leader, their sum does not
        bound how far each moves the tool.
        """
        if not self.followers[0].size:
            return self.jacobians(qs)
        drake = self._world.drake
        chosen = np.concatenate([drake.velocity_indices(self._group), self._followers[0]])
        return self._to_tangent(qs, self._plant_jacobians(qs)[:, :, chosen])

    @property
    def followers(self) -> tuple[Int64[np.ndarray, " k"], Float64[np.ndarray, " k"]]:
        """Leaders of the followers that move the tool, as indices into v, and multipliers."""
        return self._followers[1:]

    def velocities(
        self, qs: Float64[np.ndarray, "n nq"], vs: Float64[np.ndarray, "n nv"]
    ) -> Float64[np.ndarray, "n 3"]:
        """Return v_WT of T's origin [m/s] for Drake's generalized velocities."""
        if self._chain is None:
            return np.einsum("nij,nj->ni", self.velocity_jacobians(qs)[:, 3:], vs)
        found: Array = self._chain.velocities(*map(np.ascontiguousarray, (qs, vs)))
        return found

    def velocity_gradients(
        self, qs: Float64[np.ndarray, "n nq"], vs: Float64[np.ndarray, "n nv"]
    ) -> Float64[np.ndarray, "n 3 nq"] | None:
        """Return the derivatives of `velocities` by q at constant v.

        None where there is no kernel, or a joint floats.
        """
        if self._chain is None or self._floating_offsets:
            return None
        found: Array = self._chain.velocity_gradients(*map(np.ascontiguousarray, (qs, vs)))
        return found

    def velocity_jacobians(self, qs: Float64[np.ndarray, "n nq"]) -> Float64[np.ndarray, "n 6 nv"]:
        """Return the same by the group's v, which are Drake's generalized velocities."""
        if self._chain is None:
            return self._drake_jacobians(qs)
        return np.asarray(self._chain.jacobians(np.ascontiguousarray(qs)))

    def _to_tangent(self, qs: Array, by_v: Array) -> Array:
        """Return Jacobians by the tangent, given those by Drake's velocities; changes these."""
        for iq, iv in self._floating_offsets:
            turned = rotation.matrix(qs[:, iq : iq + 4])
            by_v[:, :, iv : iv + 3] = by_v[:, :, iv : iv + 3] @ turned
        return by_v

    @cached_property
    def _followers(self) -> tuple[Indices, Indices, Array]:
        """Return the plant's velocity index, the leader's in the group's v, and the multiplier.

        Only of followers between the world and the tool. A follower may lead another one.
        """
        drake = self._world.drake
        own = drake.velocity_indices(self._group).tolist()
        multiplier_of = {column: (i, 1.0) for i, column in enumerate(own)}
        for c in drake.followers_of(self._group):
            member, scale = multiplier_of[c.leader_velocity]
            multiplier_of[c.follower_velocity] = member, scale * c.multiplier
        tool = drake.frame(self.frame).body
        found = [
            (column, *multiplier_of[column])
            for column in list(multiplier_of)[len(own) :]
            if tool in drake.plant.GetBodiesKinematicallyAffectedBy([_joint_at(drake, column)])
        ]
        columns, leaders = (np.array([f[i] for f in found], dtype=np.int64) for i in range(2))
        return columns, leaders, np.array([f[2] for f in found], dtype=np.float64)

    @cached_property
    def _context(self) -> Context:
        """Drake's context, made at its first use: that takes longer than many queries."""
        return self._world.drake.plant.CreateDefaultContext()

    def _drake_jacobians(self, qs: Array) -> Array:
        drake = self._world.drake
        full = self._plant_jacobians(qs)
        for follower, leader, multiplier in reversed(drake.mimics):
            full[:, :, leader] += multiplier * full[:, :, follower]
        return full[:, :, drake.velocity_indices(self._group)]

    def _plant_jacobians(self, qs: Array) -> Array:
        """Return Drake's Jacobians by all velocities of the plant, shape (n, 6, num_velocities)."""
        plant, context = self._world.drake.plant, self._context
        frame = self._world.drake.frame(self.frame)
        found = np.empty((len(qs), 6, plant.num_velocities()))
        for i, full in enumerate(self._world.embed(self._group, qs)):
            plant.SetPositions(context, full)
            found[i] = frame.velocity_jacobian(plant, context)
        return found


def _joint_at(drake: DrakeModel, column: int) -> JointIndex:
    """Return the joint that a velocity of the plant belongs to."""
    return next(
        index
        for index in drake.joint_indices.values()
        if drake.plant.get_joint(index).velocity_start() == column
    )


def _floating_offsets(group: JointGroup) -> list[tuple[int, int]]:
    """Return the offsets in q and in v of each floating joint."""
    found: list[tuple[int, int]] = []
    iq = iv = 0
    for joint in group.joints:
        if joint.type is JointType.FLOATING:
            found.append((iq, iv))
        iq += joint.num_positions
        iv += joint.num_velocities
    return found
