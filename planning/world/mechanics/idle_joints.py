"""Idle joints: joints of a group that do not move a frame, such as those of the other arm."""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Bool
from pydrake.multibody.tree import BodyIndex

from planning.domain.robot.joints import JointGroup
from planning.world.drake_model import DrakeModel

# By names of joints and the frame.
_cache: WeakKeyDictionary[DrakeModel, dict[tuple[str, ...], Bool[np.ndarray, " nq"]]] = (
    WeakKeyDictionary()
)


def idle_positions(model: DrakeModel, group: JointGroup, frame: str) -> Bool[np.ndarray, " nq"]:
    """Return which coordinates of a group's q belong to joints that do not move a frame."""
    found = _cache.setdefault(model, {})
    key = *group.joint_names, frame
    if key not in found:
        found[key] = _idle_positions(model, group, frame)
    return found[key]


def _idle_positions(model: DrakeModel, group: JointGroup, frame: str) -> Bool[np.ndarray, " nq"]:
    body = model.frame(frame).body
    if not model.couplings:
        flags = _are_off_the_chain(model, group, body)
        return _frozen_flags(flags)
    flags = list[bool]()
    for joint in group.joints:
        single = JointGroup(joint.name, (joint,), ())
        velocities = {c.follower_velocity for c in model.followers_of(single)}
        followers = [
            index
            for index in model.joint_indices.values()
            if model.plant.get_joint(index).num_velocities() == 1
            and model.plant.get_joint(index).velocity_start() in velocities
        ]
        moving = [model.joint_indices[joint.name], *followers]
        affected = model.plant.GetBodiesKinematicallyAffectedBy(moving)
        flags += [body not in affected] * joint.num_positions
    return _frozen_flags(flags)


def _are_off_the_chain(model: DrakeModel, group: JointGroup, body: BodyIndex) -> list[bool]:
    """Return the same without mimic joints: whether a joint is not between the world and a body.

    The tree is looked at once, where Drake would list all that moves for every joint.
    """
    plant: Any = model.plant
    joints = [plant.get_joint(i) for i in plant.GetJointIndices()]
    above = {joint.child_body().index(): joint for joint in joints}
    moving: set[Any] = set()
    here = body
    while (joint := above.get(here)) is not None:
        moving.add(joint.index())
        here = joint.parent_body().index()
    return [
        model.joint_indices[joint.name] not in moving
        for joint in group.joints
        for _ in range(joint.num_positions)
    ]


def _frozen_flags(flags: list[bool]) -> Bool[np.ndarray, " nq"]:
    idle = np.array(flags, dtype=bool)
    idle.setflags(write=False)
    return idle
