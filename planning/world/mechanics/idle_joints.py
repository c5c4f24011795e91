"""Idle joints: joints of a group that do not move a frame, such as those of the other arm."""

from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Bool

from planning.domain.robot.joints import JointGroup
from planning.world.drake_model import DrakeModel

# By names of joints and the frame.
_cache: WeakKeyDictionary[DrakeModel, dict[tuple[str, ...], Bool[np.ndarray, " nq"]]] = (
    WeakKeyDictionary()
)


def idle_positions(model: DrakeModel, group: JointGroup, frame: str) -> Bool[np.ndarray, " nq"]:
    """Return which coordinates of a group's q belong to joints that do not move a frame."""
    found = _cache.setdefault(model, {})
    key = *(joint.name for joint in group.joints), frame
    if key not in found:
        found[key] = _idle_positions(model, group, frame)
    return found[key]


def _idle_positions(model: DrakeModel, group: JointGroup, frame: str) -> Bool[np.ndarray, " nq"]:
    body = model.frame(frame).body
    flags: list[bool] = []
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
    idle = np.array(flags, dtype=bool)
    idle.setflags(write=False)
    return idle
