"""IkProgram: inverse kinematics of one target pose as a Drake program, solved from many seeds."""

import numpy as np
from jaxtyping import Float64
from pydrake.math import RigidTransform, RotationMatrix

from planning.domain.arrays import Array
from planning.domain.geometry.pose import Pose
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.goals.ik.group_program import GroupProgram
from planning.goals.targets.tool_target import FreedomKind, ToolTarget
from planning.world.world import World, pose_of

_MAJOR_ITERATIONS = 100
_MAX_NEWTON_STEPS = 8
# Error of a pose at which Newton steps end [rad or m].
_NEWTON_TOLERANCE = 1e-10
# Singular values below this share of the largest are zero in a Newton step.
_RCOND = 1e-7


class IkProgram:
    """Drake's InverseKinematics for one target; the joints outside the group stay as they are."""

    def __init__(self, world: World, group: JointGroup, target: ToolTarget) -> None:
        """Build the program; solving it again only changes the initial guess."""
        self._world = world
        self._target = target
        self._manifold = Manifold(group.joints)
        self._plant = world.drake.plant
        self._frame = world.drake.frame(target.frame)
        self._program = GroupProgram(world, group, _MAJOR_ITERATIONS)
        self._v_indices = world.drake.velocity_indices(group)
        self._add_constraints()

    def solve(self, seed: Float64[np.ndarray, " nq"]) -> Array | None:
        """Return a configuration of the group that meets the target, shape (nq,).

        None if the solver ends elsewhere: one trial of many, not a failure of the stage.
        """
        q = self._refine(self._manifold.normalized(self._program.solve(seed)))
        return q if self._target.is_met_by(self.tool_pose(q)) else None

    def tool_pose(self, q: Float64[np.ndarray, " nq"]) -> Pose:
        """Return the tool frame's pose X_WT with the group at q."""
        context = self._program.context
        self._plant.SetPositions(context, self._program.embed(q))
        return pose_of(self._frame.pose(context))

    def _refine(self, q: Array) -> Array:
        """Refine q by Newton steps on the pose error.

        Drake's orientation constraint is accurate to 1e-3 rad only: its residual is
        cos(theta) - 1, whose slope vanishes at the solution.
        """
        for _ in range(_MAX_NEWTON_STEPS):
            tool_pose = self.tool_pose(q)
            error = _twist_to(tool_pose, self._target.closest(tool_pose))
            if np.abs(error).max() < _NEWTON_TOLERANCE:
                break
            jacobian = self._jacobian()
            step = np.linalg.lstsq(jacobian, error, rcond=_RCOND)[0]
            if np.linalg.norm(step) > 0.5:
                break
            q = self._integrate(q, step)
        return q

    def _jacobian(self) -> Array:
        """Return the tool's spatial-velocity Jacobian for the group's v, mimic joints included."""
        full = self._frame.velocity_jacobian(self._plant, self._program.context)
        for follower, leader, multiplier in reversed(self._world.drake.mimics):
            full[:, leader] += multiplier * full[:, follower]
        return full[:, self._v_indices]

    def _integrate(self, q: Array, v: Array) -> Array:
        """Return q integrated by Drake's v for one second, to first order.

        Drake's v and this package's tangents agree except on SO(3).
        """
        if self._manifold.is_flat:
            return q + v
        full_v = np.zeros(self._plant.num_velocities())
        full_v[self._v_indices] = v
        qdot = self._plant.MapVelocityToQDot(self._program.context, full_v)
        return self._manifold.normalized(q + qdot[self._program.q_indices])

    def _add_constraints(self) -> None:
        target = self._target
        world = self._plant.world_frame()
        x_wg = RigidTransform(target.pose.matrix)
        box = target.position_tolerance
        frame = self._frame.frame
        self._program.ik.AddPositionConstraint(frame, self._frame.origin, world, x_wg, -box, box)
        freedom = target.rotation_freedom
        if freedom.kind is FreedomKind.CONE:
            axis = np.eye(3)[freedom.axis]
            n_w = x_wg.rotation().multiply(axis)
            bounds = 0.0, freedom.bound
            n_t = self._frame.rotation @ axis
            self._program.ik.AddAngleBetweenVectorsConstraint(world, n_w, frame, n_t, *bounds)
        elif freedom.kind is FreedomKind.BALL:
            R_FT = RotationMatrix(self._frame.rotation)
            self._program.ik.AddOrientationConstraint(
                world, x_wg.rotation(), frame, R_FT, freedom.bound
            )


def _twist_to(tool_pose: Pose, desired: Pose) -> Array:
    """Return the spatial displacement [rotation; translation] from one pose to another, in W."""
    turn = RotationMatrix(desired.matrix[:3, :3] @ tool_pose.matrix[:3, :3].T).ToAngleAxis()
    return np.concatenate([turn.angle() * turn.axis(), desired.position - tool_pose.position])
