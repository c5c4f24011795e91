"""ToolTarget: target pose of a tool frame in world, with position and rotation tolerances."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import PoseBall, PoseGoal, PoseTarget, RegionGoal, RelativeGoal
from planning.domain.goals.linear_moves import Displacement
from planning.domain.robot.joints import JointGroup
from planning.domain.value import Value
from planning.world.world import World

# Accuracy of a solution for an exact target after Newton refinement [m and rad].
POSE_TOLERANCE = 1e-6


class FreedomKind(StrEnum):
    """Kind of a rotation tolerance; each name is also one of the kernel's Freedom (kinds.hpp)."""

    BALL = "ball"
    CONE = "cone"
    FREE = "free"


@dataclass(frozen=True)
class RotationFreedom:
    """Tolerance of a rotation R_GT.

    Attributes:
        kind: BALL: the rotation angle is bounded. CONE: the tilt of one axis is bounded, rotation
            about it is free. FREE: every rotation is within tolerance.
        axis: Index of the cone's axis, the same in G and in T.
        bound: Bound on the angle [rad].
    """

    kind: FreedomKind
    axis: int
    bound: float


@dataclass(frozen=True, eq=False)
class ToolTarget(Value):
    """Target pose of a tool frame T with tolerances.

    Attributes:
        frame: Full name of T.
        pose: X_WG, the target frame G.
        position_tolerance: Half-widths of the box about G, in G's axes [m], shape (3,).
        rotation_tolerance: Bounds on the rotation vector of R_GT by G's axes [rad], shape (3,);
            pi or more leaves an axis free.
    """

    frame: str
    pose: Pose
    position_tolerance: Float64[np.ndarray, "3"]
    rotation_tolerance: Float64[np.ndarray, "3"]

    def closest(self, tool_pose: Pose) -> Pose:
        """Return the pose within tolerance that is closest to X_WT, up to second order."""
        error = self.pose.inverse @ tool_pose
        box = self.position_tolerance
        return self.pose @ Pose(
            np.clip(error.position, -box, box), self._closest_rotation(error.quaternion)
        )

    def _closest_rotation(self, error: Array) -> Array:
        """Return the rotation R_GT within tolerance that is closest to the one given."""
        freedom = self.rotation_freedom
        if freedom.kind is FreedomKind.FREE:
            return error
        if freedom.kind is FreedomKind.CONE:
            axis = np.eye(3)[freedom.axis]
            tilted_axis = rotation.rotate(error, axis)
            swing_axis = np.cross(tilted_axis, axis)
            sine = float(np.linalg.norm(swing_axis))
            angle = float(np.arctan2(sine, tilted_axis @ axis))
            if angle <= freedom.bound or sine < 1e-12:
                return error
            return rotation.multiply(
                rotation.exp(swing_axis / sine * (angle - freedom.bound)), error
            )
        turn = rotation.log(error)
        angle = float(np.linalg.norm(turn))
        return error if angle <= freedom.bound else rotation.exp(turn * (freedom.bound / angle))

    def pose_errors(
        self, tool_poses: Float64[np.ndarray, "n 4 4"]
    ) -> tuple[Float64[np.ndarray, " n"], Float64[np.ndarray, " n"]]:
        """Return the errors of each X_WT beyond the tolerances: translation [m], rotation [rad]."""
        x_wg = self.pose.matrix
        offset = np.abs((tool_poses[:, :3, 3] - x_wg[:3, 3]) @ x_wg[:3, :3])
        shift = np.linalg.norm(np.maximum(offset - self.position_tolerance, 0.0), axis=1)
        return shift, np.maximum(
            self._rotation_angles(tool_poses) - self.rotation_freedom.bound, 0.0
        )

    def _rotation_angles(self, tool_poses: Array) -> Array:
        """Return the bounded angle of each X_WT [rad]; 0 if the rotation is free."""
        freedom = self.rotation_freedom
        if freedom.kind is FreedomKind.FREE:
            return np.zeros(len(tool_poses))
        change = tool_poses[:, :3, :3] - self.pose.matrix[:3, :3]
        # |R_1 - R_2| = sqrt(8) sin(angle / 2); for one column it is the chord of the column's tilt.
        chord = (
            np.linalg.norm(change, axis=(1, 2)) / np.sqrt(2)
            if freedom.kind is FreedomKind.BALL
            else np.linalg.norm(change[:, :, freedom.axis], axis=1)
        )
        return 2 * np.arcsin(np.minimum(chord / 2, 1.0))

    def is_met_by(self, tool_pose: Pose) -> bool:
        """Return whether X_WT is within tolerance of the target."""
        return bool(self.are_met_by(tool_pose.matrix[None])[0])

    def are_met_by(self, tool_poses: Float64[np.ndarray, "n 4 4"]) -> Bool[np.ndarray, " n"]:
        """Return whether each homogeneous transform X_WT is within tolerance of the target."""
        x_wg = self.pose.matrix
        offset = (tool_poses[:, :3, 3] - x_wg[:3, 3]) @ x_wg[:3, :3]
        inside = (np.abs(offset) <= self.position_tolerance + POSE_TOLERANCE).all(axis=1)
        return inside & (
            self._rotation_angles(tool_poses) <= self.rotation_freedom.bound + POSE_TOLERANCE
        )

    def widened_tolerances(self, tool_pose: Pose) -> tuple[Array, Array]:
        """Return position [m] and rotation [rad] tolerances that also include X_WT."""
        offset = np.abs((self.pose.inverse @ tool_pose).position)
        freedom = self.rotation_freedom
        turn = self.rotation_tolerance
        if freedom.kind is not FreedomKind.FREE:
            excess = self.closest(tool_pose).distance(tool_pose)[1]
            turn = np.where(turn >= np.pi, turn, freedom.bound + excess)
        return np.maximum(offset, self.position_tolerance), turn

    @property
    def rotation_freedom(self) -> RotationFreedom:
        """Rotation tolerance of R_GT by kind; the smallest bound counts where several are given."""
        free = self.rotation_tolerance >= np.pi
        if free.all():
            return RotationFreedom(FreedomKind.FREE, 0, 0.0)
        bound = float(self.rotation_tolerance[~free].min())
        if free.sum() == 1:
            return RotationFreedom(FreedomKind.CONE, int(np.flatnonzero(free)[0]), bound)
        return RotationFreedom(FreedomKind.BALL, 0, bound)


def pose_in_world(world: World, full: Array, target: PoseTarget) -> Pose:
    """Return a target's pose in world, with moving frames evaluated at a configuration.

    Args:
        world: Loaded scene.
        full: Configuration of the whole scene, for frames that move.
        target: Pose and the frame that it is given in.

    Raises:
        UnknownName: The frame does not exist.
    """
    if target.frame == "world":
        return target.pose
    return world.frame_pose(target.frame, full) @ target.pose


def line_end(world: World, full: Array, begin: Pose, target: PoseTarget | Displacement) -> Pose:
    """Return the end pose X_WT of a tool line.

    Args:
        world: Loaded scene.
        full: Configuration of the whole scene, for frames that move.
        begin: X_WT at the beginning of the line.
        target: End pose, or displacement to it.

    Raises:
        UnknownName: A frame does not exist.
    """
    match target:
        case PoseTarget():
            return pose_in_world(world, full, target)
        case Displacement():
            axes = pose_in_world(world, full, PoseTarget(Pose.identity(), target.frame))
            translation = rotation.rotate(axes.quaternion, np.asarray(target.vector))
            return Pose(begin.position + translation, begin.quaternion)


def tool_targets(
    world: World,
    group: JointGroup,
    goal: PoseGoal | RegionGoal,
    start: Float64[np.ndarray, " nq"],
) -> list[ToolTarget]:
    """Return the goal's targets in world, with moving frames evaluated at the start.

    Raises:
        UnknownName: A frame does not exist.
    """
    tool = goal.frame or group.tool_frames[0]
    world.validate_frame(tool)
    full = world.embed(group, start)
    return [
        ToolTarget(
            tool,
            pose_in_world(world, full, target),
            goal.position_tolerance,
            goal.rotation_tolerance,
        )
        for target in goal.targets
    ]


def weight_axes(world: World, full: Array, ball: PoseBall, target: Pose) -> Array:
    """Return R_WA as a quaternion: the axes of the distance weights of a ball about X_WG.

    Raises:
        UnknownName: The frame does not exist.
    """
    if not ball.frame:
        return target.quaternion
    return pose_in_world(world, full, PoseTarget(Pose.identity(), ball.frame)).quaternion


def relative_target(
    world: World, group: JointGroup, goal: RelativeGoal, start: Float64[np.ndarray, " nq"]
) -> ToolTarget:
    """Return the target of a relative goal: the tool's start pose moved by the displacement.

    Raises:
        UnknownName: A frame does not exist.
    """
    tool = goal.frame or group.tool_frames[0]
    full = world.embed(group, start)
    x_wt = world.frame_pose(tool, full)
    goal_pose = x_wt @ goal.displacement
    if goal.reference:
        a_wf = world.frame_pose(goal.reference, full).quaternion
        turn = rotation.multiply(
            rotation.multiply(a_wf, goal.displacement.quaternion), rotation.conjugate(a_wf)
        )
        shift = rotation.rotate(a_wf, goal.displacement.position)
        goal_pose = Pose.from_parts(x_wt.position + shift, rotation.multiply(turn, x_wt.quaternion))
    return ToolTarget(tool, goal_pose, np.zeros(3), np.zeros(3))
