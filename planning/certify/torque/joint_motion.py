"""JointMotion: joints of a group as chains of one-coordinate motions of links.

A planar joint is two prismatic motions and a revolute one, a floating joint three prismatic motions
and a spherical one.
"""

from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
from pydrake.multibody.tree import (
    PlanarJoint,
    PrismaticJoint,
    QuaternionFloatingJoint,
    RevoluteJoint,
)

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.errors import ModelInvalid
from planning.world.drake_model import DrakeModel


class MotionKind(Enum):
    """Kind of motion of a link relative to its parent."""

    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"
    SPHERICAL = "spherical"


@dataclass(frozen=True)
class JointMotion:
    """A joint coordinate that moves a link.

    Attributes:
        kind: Kind of motion.
        axis: Unit axis of a revolute or prismatic motion, shape (3,).
        velocity_index: Index of the (first) coordinate in the group's v.
        position_index: Index of the (first) coordinate in the group's q.
        scale: Ratio of the link's displacement to that of the coordinate, with sign.
        offset: Constant added for a follower [rad or m].
        damping: Viscous damping [N m s/rad or N s/m].
        rotor_inertia: Reflected inertia of the motor's rotor [kg m^2 or kg].
    """

    kind: MotionKind
    axis: Array
    velocity_index: int
    position_index: int
    scale: float = 1.0
    offset: float = 0.0
    damping: float = 0.0
    rotor_inertia: float = 0.0

    @property
    def reversed(self) -> "JointMotion":
        """The same motion seen from the other side; not for spherical motions."""
        return replace(self, scale=-self.scale, offset=-self.offset)


class JointMotions:
    """Motions of all joints that the group moves."""

    def __init__(self, model: DrakeModel, group: JointGroup) -> None:
        plant = model.plant
        self._motions: dict[int, list[JointMotion]] = {}
        by_velocity: dict[int, JointMotion] = {}
        iq = iv = 0
        for joint in group.joints:
            drake = plant.get_joint(model.joint_indices[joint.name])
            motions = _of_joint(drake, iq, iv)
            self._motions[int(drake.index())] = motions
            for motion in motions:
                if motion.kind is not MotionKind.SPHERICAL:
                    by_velocity[drake.velocity_start() + motion.velocity_index - iv] = motion
            iq, iv = iq + joint.num_positions, iv + joint.num_velocities
        joints = [plant.get_joint(index) for index in plant.GetJointIndices()]
        by_start = {j.velocity_start(): j for j in joints if j.num_velocities() == 1}
        for c in model.followers_of(group):
            leader = by_velocity[c.leader_velocity]
            (follower_motion,) = _of_joint(by_start[c.follower_velocity], 0, 0)
            motion = replace(
                follower_motion,
                velocity_index=leader.velocity_index,
                position_index=leader.position_index,
                scale=c.multiplier * leader.scale,
                offset=c.multiplier * leader.offset + c.offset,
            )
            by_velocity[c.follower_velocity] = motion
            self._motions[int(by_start[c.follower_velocity].index())] = [motion]

    def of(self, joint: Any) -> list[JointMotion]:
        """Return the motions of a joint in order; empty if it does not move."""
        return self._motions.get(int(joint.index()), [])


def _of_joint(joint: Any, iq: int, iv: int) -> list[JointMotion]:
    x, y, z = np.eye(3)
    match joint:
        case RevoluteJoint():
            return [JointMotion(MotionKind.REVOLUTE, np.array(joint.revolute_axis()), iv, iq)]
        case PrismaticJoint():
            return [JointMotion(MotionKind.PRISMATIC, np.array(joint.translation_axis()), iv, iq)]
        case PlanarJoint():
            slides = [
                JointMotion(MotionKind.PRISMATIC, axis, iv + i, iq + i)
                for i, axis in enumerate((x, y))
            ]
            return [*slides, JointMotion(MotionKind.REVOLUTE, z, iv + 2, iq + 2)]
        case QuaternionFloatingJoint():
            slides = [
                JointMotion(MotionKind.PRISMATIC, axis, iv + 3 + i, iq + 4 + i)
                for i, axis in enumerate((x, y, z))
            ]
            return [*slides, JointMotion(MotionKind.SPHERICAL, z, iv, iq)]
        case _:
            message = f"joint {joint.name()!r} of kind {joint.type_name()!r} cannot be certified"
            raise ModelInvalid(message, {"joint": joint.name(), "reason": message})
