"""Grippers of a scene: which groups are one, and which bodies their fingers are."""

import numpy as np
from pydrake.multibody.tree import PrismaticJoint

from planning.domain.robot.gripper import Gripper
from planning.domain.robot.joints import JointGroup, JointType
from planning.errors import ProblemInvalid
from planning.world.mechanics.joint_followers import joint_followers
from planning.world.world import World


def gripper_of(world: World, group: JointGroup) -> Gripper | None:
    """Return the gripper that a group of a robot is, or None.

    It is one if it is not the robot's default group and has one joint, which is prismatic and
    limited, and other prismatic joints follow that. Descriptions do not say which way fingers
    close: they are taken to meet at the joint's lower limit, as in those of common grippers.
    """
    is_default = any(own.groups.get(own.default) is group for own in world.robot_groups)
    kinds = [joint.type for joint in group.joints]
    if is_default or kinds != [JointType.PRISMATIC]:
        return None
    joint = group.joints[0].name
    followers = [each for each in joint_followers(world.drake, joint) if each.multiplier != 0]
    if not followers or not all(isinstance(each.joint, PrismaticJoint) for each in followers):
        return None
    limits = world.limits(group)
    lower, upper = float(limits.lower[0]), float(limits.upper[0])
    if not (np.isfinite([lower, upper]).all() and lower < upper):
        return None
    return Gripper(joint, lower, upper, 1.0 + sum(abs(each.multiplier) for each in followers))


def require_gripper(world: World, group: JointGroup) -> Gripper:
    """Return the gripper that a group is.

    Raises:
        ProblemInvalid: It is none; evidence has those of the scene.
    """
    found = gripper_of(world, group)
    if found is None:
        known = [each.name for each in world.groups if gripper_of(world, each) is not None]
        joints = [f"{joint.name} ({joint.type})" for joint in group.joints]
        message = (
            f"group {group.name!r} is no gripper: that is one prismatic joint that others like it "
            f"follow, and not the robot's default group, and it moves {', '.join(joints)}; others "
            f"are opened and closed by plans of their joints; grippers: {known}"
        )
        evidence = {"field": "group", "known": known, "joints": [j.name for j in group.joints]}
        raise ProblemInvalid(message, evidence)
    return found


def finger_bodies(world: World, gripper: Gripper) -> list[tuple[float, frozenset[str]]]:
    """Return each finger: how fast it moves with the gripper's joint, and its bodies' full names.

    What a robot holds is no part of a finger.
    """
    model = world.drake
    joints = [(1.0, model.joint_indices[gripper.joint])]
    joints += [
        (abs(each.multiplier), each.joint.index())
        for each in joint_followers(model, gripper.joint)
        if each.multiplier != 0
    ]
    fingers: list[tuple[float, frozenset[str]]] = []
    for rate, index in joints:
        moved = model.plant.GetBodiesKinematicallyAffectedBy([index])
        names = {model.body_names[body] for body in moved if body in model.body_names}
        fingers.append((rate, frozenset(names - set(model.owners))))
    return fingers
