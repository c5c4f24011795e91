"""ConstraintCompiler: from a path constraint to its compiled constraint."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.request.constraint import (
    DistanceBand,
    KeepIn,
    KeepOut,
    LockedJoints,
    OrientationCone,
    PathConstraint,
    PathPredicate,
    PlacedBox,
    PositionBand,
    TightLimits,
    constraint_label,
)
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.world.constraints.band_constraint import BandConstraint
from planning.world.constraints.body_pairs import banded_pairs
from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.constraints.compiled_constraint import CompiledConstraint
from planning.world.constraints.cone_constraint import ConeConstraint
from planning.world.constraints.joint_constraints import LimitConstraint, LockConstraint
from planning.world.constraints.predicate_constraint import PredicateConstraint
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World


@dataclass(frozen=True)
class ConstraintCompiler:
    """Compiler of path constraints for one world, group and start.

    Attributes:
        world: The scene.
        group: Group of the configurations.
        start: Configuration at which frames and joints are taken, the group's q, shape (nq,).
    """

    world: World
    group: JointGroup
    start: Float64[np.ndarray, " nq"]

    def compile_constraint(self, index: int, constraint: PathConstraint) -> CompiledConstraint:
        """Return the compiled constraint of the path constraint with this index in the request.

        Raises:
            UnknownName: A body does not exist.
            ProblemInvalid: A distance band applies to no pair of bodies.
        """
        label = constraint_label(index, constraint)
        match constraint:
            case DistanceBand():
                pairs = banded_pairs(
                    self.world, self.group, constraint, f"path_constraints.{index}"
                )
                return BandConstraint(
                    label, self.world, self.group, pairs, constraint.min, constraint.max
                )
            case KeepOut() | KeepIn() | PositionBand():
                kinematics = ToolKinematics(self.world, self.group, constraint.frame)
                is_inside = not isinstance(constraint, KeepOut)
                half = constraint.box.size / 2
                return BoxConstraint(
                    label, kinematics, self._box_pose(constraint.box), half, is_inside
                )
            case OrientationCone():
                return self._cone(label, constraint)
            case LockedJoints() | TightLimits():
                return self._joints(label, constraint)
            case PathPredicate():
                name = f"{label} {constraint.name}".removesuffix(" predicate")
                return PredicateConstraint(name, constraint.predicate, constraint.resolution)

    def _reference(self, name: str) -> Pose:
        return self.world.frame_pose(name, self.world.embed(self.group, self.start))

    def _box_pose(self, box: PlacedBox) -> Pose:
        return self._reference(box.reference) @ box.pose

    def _cone(self, label: str, cone: OrientationCone) -> ConeConstraint:
        R_WF = rotation.matrix(self._reference(cone.reference).quaternion)
        direction = R_WF @ cone.direction
        return ConeConstraint(
            label,
            ToolKinematics(self.world, self.group, cone.frame),
            cone.axis / np.linalg.norm(cone.axis),
            direction / np.linalg.norm(direction),
            cone.tolerance,
        )

    def _joints(self, label: str, constraint: LockedJoints | TightLimits) -> CompiledConstraint:
        joints = self.group.joints
        if isinstance(constraint, LockedJoints):
            flags = [j.name in constraint.joints for j in joints for _ in range(j.num_velocities)]
            locked = np.array(flags, dtype=bool)
            return LockConstraint(
                label, Manifold(joints), self.start, locked, self.group.velocity_names
            )
        lower = np.full(self.group.num_positions, -np.inf)
        upper, is_circle = -lower, np.zeros(len(lower), dtype=bool)
        names = self.group.position_names
        for name, (low, high) in constraint.limits.items():
            lower[names.index(name)], upper[names.index(name)] = low, high
        iq = 0
        for joint in joints:
            if any(joint.wraps):
                is_circle[iq : iq + joint.num_positions] = joint.wraps
            iq += joint.num_positions
        return LimitConstraint(label, lower, upper, is_circle, names)
