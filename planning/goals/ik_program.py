"""IkProgram: one target pose as a Drake inverse-kinematics program, solved from many seeds."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.solvers import SnoptSolver, SolverOptions

from planning.domain import rotation
from planning.domain.joints import JointGroup
from planning.domain.manifold import Manifold
from planning.domain.pose import Pose
from planning.domain.value import Value
from planning.world.world import World, pose_of

type Array = np.ndarray[Any, np.dtype[np.float64]]

_MAJOR_ITERATIONS = 100
_POLISH_STEPS = 8
_POLISHED = 1e-10
_RCOND = 1e-7
# How far a solution may miss an exact target after polishing [m and rad].
POSE_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class ToolTarget(Value):
    """Where the tool frame T shall be.

    Attributes:
        frame: Full name of T.
        pose: X_WG.
        position_tolerance: Half-widths of the box about G, in G's axes [m], shape (3,).
        rotation_tolerance: Bounds on the rotation vector of R_GT by G's axes [rad], shape (3,);
            pi or more leaves an axis free.
    """

    frame: str
    pose: Pose
    position_tolerance: Float64[np.ndarray, "3"]
    rotation_tolerance: Float64[np.ndarray, "3"]

    def closest(self, reached: Pose) -> Pose:
        """Return the pose within tolerance that is closest to X_WT, up to second order."""
        error = self.pose.inverse @ reached
        box = self.position_tolerance
        return self.pose @ Pose(
            np.clip(error.position, -box, box), self._closest_rotation(error.quaternion)
        )

    def _closest_rotation(self, error: Array) -> Array:
        """Return the rotation R_GT within tolerance that is closest to the one given."""
        free = self.rotation_tolerance >= np.pi
        if free.all():
            return error
        bound = float(self.rotation_tolerance[~free].min())
        if free.sum() == 1:
            axis = np.eye(3)[int(np.flatnonzero(free)[0])]
            leaning = rotation.rotate(error, axis)
            swing_axis = np.cross(leaning, axis)
            sine = float(np.linalg.norm(swing_axis))
            angle = float(np.arctan2(sine, leaning @ axis))
            if angle <= bound or sine < 1e-12:
                return error
            return rotation.multiply(rotation.exp(swing_axis / sine * (angle - bound)), error)
        turn = rotation.log(error)
        angle = float(np.linalg.norm(turn))
        return error if angle <= bound else rotation.exp(turn * (bound / angle))

    def is_met_by(self, reached: Pose) -> bool:
        """Return whether X_WT is within tolerance of the target."""
        error = self.pose.inverse @ reached
        turn = Pose.identity().distance(error)[1]
        free = self.rotation_tolerance >= np.pi
        inside = np.abs(error.position) <= self.position_tolerance + POSE_TOLERANCE
        if free.all():
            return bool(inside.all())
        bound = float(self.rotation_tolerance[~free].min()) + POSE_TOLERANCE
        if free.sum() == 1:
            turn = _angle_between_axes(error, int(np.flatnonzero(free)[0]))
        return bool(inside.all()) and turn <= bound


class IkProgram:
    """Drake's InverseKinematics for one target; the joints outside the group stay as they are."""

    def __init__(self, world: World, group: JointGroup, target: ToolTarget) -> None:
        """Build the program; solving it again only changes the initial guess."""
        self._world = world
        self._target = target
        self._manifold = Manifold(group.joints)
        self._plant = world.drake.plant
        self._frame = world.drake.frames[target.frame]
        self._context = self._locked_context(group)
        self._q_indices = world.drake.position_indices(group)
        self._v_indices = world.drake.velocity_indices(group)
        self._ik = InverseKinematics(self._plant, self._context, with_joint_limits=True)
        self._bound_positions(group)
        self._constrain()
        self._solver = SnoptSolver()
        self._options = SolverOptions()
        self._options.SetOption(SnoptSolver.id(), "Major iterations limit", _MAJOR_ITERATIONS)

    def solve(self, seed: Float64[np.ndarray, " nq"]) -> Array | None:
        """Return a configuration of the group that meets the target, shape (nq,).

        None if the solver ends elsewhere: one trial of many, not a failure of the stage.
        """
        guess = np.array(self._world.state)
        guess[self._q_indices] = seed
        result = self._solver.Solve(self._ik.prog(), guess, self._options)
        q = self._manifold.normalized(result.GetSolution(self._ik.q())[self._q_indices])
        q = self._polish(q)
        return q if self._target.is_met_by(self.reached(q)) else None

    def reached(self, q: Float64[np.ndarray, " nq"]) -> Pose:
        """Return X_WT of the tool frame with the group at q."""
        full = np.array(self._world.state)
        full[self._q_indices] = q
        self._plant.SetPositions(self._context, full)
        return pose_of(self._frame.CalcPoseInWorld(self._context))

    def _polish(self, q: Array) -> Array:
        """Newton steps on the pose error: Drake's orientation constraint is only good to 1e-3 rad.

        Its residual is cos(theta) - 1, whose slope vanishes at the solution.
        """
        for _ in range(_POLISH_STEPS):
            reached = self.reached(q)
            error = _twist_to(reached, self._target.closest(reached))
            if np.abs(error).max() < _POLISHED:
                break
            jacobian = self._plant.CalcJacobianSpatialVelocity(
                self._context,
                JacobianWrtVariable.kV,
                self._frame,
                np.zeros(3),
                self._plant.world_frame(),
                self._plant.world_frame(),
            )[:, self._v_indices]
            step = np.linalg.lstsq(jacobian, error, rcond=_RCOND)[0]
            if np.linalg.norm(step) > 0.5:
                break
            q = self._step(q, step)
        return q

    def _step(self, q: Array, v: Array) -> Array:
        """Return q moved by Drake's v for one second (v and our tangent agree but for SO(3))."""
        if self._manifold.is_flat:
            return q + v
        full_v = np.zeros(self._plant.num_velocities())
        full_v[self._v_indices] = v
        qdot = self._plant.MapVelocityToQDot(self._context, full_v)[self._q_indices]
        return self._manifold.normalized(q + qdot)

    def _locked_context(self, group: JointGroup) -> Any:
        diagram_context = self._world.drake.diagram.CreateDefaultContext()
        context = self._plant.GetMyMutableContextFromRoot(diagram_context)
        self._diagram_context = diagram_context
        self._plant.SetPositions(context, self._world.state)
        moving = {self._world.drake.joint_indices[joint.name] for joint in group.joints}
        for index in self._world.drake.joint_indices.values():
            if index not in moving:
                self._plant.get_joint(index).Lock(context)
        return context

    def _bound_positions(self, group: JointGroup) -> None:
        """Bound what Drake's plant does not: planar and floating joints have limits of ours."""
        limits = self._world.limits(group)
        bounded = np.isfinite(limits.lower) & np.isfinite(limits.upper)
        variables = self._ik.q()[self._q_indices][bounded]
        if bounded.any():
            self._ik.get_mutable_prog().AddBoundingBoxConstraint(
                limits.lower[bounded], limits.upper[bounded], variables
            )

    def _constrain(self) -> None:
        target = self._target
        world = self._plant.world_frame()
        x_wg = RigidTransform(target.pose.matrix)
        box = target.position_tolerance
        self._ik.AddPositionConstraint(self._frame, np.zeros(3), world, x_wg, -box, box)
        free = target.rotation_tolerance >= np.pi
        if free.all():
            return
        bound = float(target.rotation_tolerance[~free].min())
        if free.sum() == 1:
            axis = np.eye(3)[int(np.flatnonzero(free)[0])]
            n_w = x_wg.rotation().multiply(axis)
            self._ik.AddAngleBetweenVectorsConstraint(world, n_w, self._frame, axis, 0.0, bound)
        else:
            self._ik.AddOrientationConstraint(
                world, x_wg.rotation(), self._frame, RotationMatrix(), bound
            )


def _twist_to(reached: Pose, wanted: Pose) -> Array:
    """Return the spatial displacement [rotation; translation] from one pose to another, in W."""
    turn = RotationMatrix(wanted.matrix[:3, :3] @ reached.matrix[:3, :3].T).ToAngleAxis()
    return np.concatenate([turn.angle() * turn.axis(), wanted.position - reached.position])


def _angle_between_axes(error: Pose, axis: int) -> float:
    cosine = float(np.clip(error.matrix[axis, axis], -1.0, 1.0))
    return float(np.arccos(cosine))
