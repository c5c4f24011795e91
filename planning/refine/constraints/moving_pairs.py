"""Drake collision checker restricted to pairs whose distance a group's motion changes."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool
from pydrake.multibody.tree import BodyIndex, JointIndex
from pydrake.planning import SceneGraphCollisionChecker

from planning.domain.robot.joints import JointGroup
from planning.refine.constraints.distance_buffers import PairThresholds
from planning.world.collision.drake_checker import distance_checker
from planning.world.drake_model import DrakeModel


def group_checker(
    model: DrakeModel, group: JointGroup, thresholds: PairThresholds
) -> SceneGraphCollisionChecker:
    """Return a checker whose clearances are zero where a pair is at its required distance.

    Required distances enter as Drake's padding, so that one bound (zero) serves all pairs. Pairs
    whose distance does not depend on the group's q are left out: the optimizer cannot change them,
    and a robot that stands near a wall would make every problem infeasible.
    """
    plant = model.plant
    instances = {
        plant.get_joint(index).child_body().model_instance()
        for index in model.joint_indices.values()
    }
    checker = distance_checker(model, sorted(instances, key=int))
    last_joints = _last_moving_joints(model, group)
    padding = np.array(checker.GetPaddingMatrix())
    filters = np.array(checker.GetNominalFilteredCollisionMatrix())
    bodies = [(index, plant.get_body(index)) for index in sorted(model.body_names, key=int)]
    for i, (a, body_a) in enumerate(bodies):
        for b, body_b in bodies[i + 1 :]:
            if not (checker.IsPartOfRobot(body_a) or checker.IsPartOfRobot(body_b)):
                continue
            row, column = int(a), int(b)
            threshold = thresholds.threshold(model.body_names[a], model.body_names[b])
            padding[row, column] = padding[column, row] = threshold
            if last_joints[a] == last_joints[b] and filters[row, column] == 0:
                filters[row, column] = filters[column, row] = 1
    checker.SetPaddingMatrix(padding)
    checker.SetCollisionFilterMatrix(filters)
    return checker


def moved_pairs(
    model: DrakeModel, group: JointGroup, pairs: Sequence[tuple[str, str]]
) -> Bool[np.ndarray, " n"]:
    """Return which pairs of bodies, by full names, the group moves relative to each other."""
    last_joints = _last_moving_joints(model, group)
    last_joint_pairs = [[last_joints.get(model.bodies[name]) for name in pair] for pair in pairs]
    return np.array([a != b for a, b in last_joint_pairs], dtype=bool)


def _last_moving_joints(model: DrakeModel, group: JointGroup) -> dict[BodyIndex, JointIndex | None]:
    """Return for every body the last of the group's moving joints on the chain from the world.

    Two bodies with the same one keep their relative pose, whatever the group does.
    """
    plant = model.plant
    moving = _moving_joints(model, group)
    joint_by_child: dict[BodyIndex, Any] = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        joint_by_child[joint.child_body().index()] = joint
    last_joints: dict[BodyIndex, JointIndex | None] = {}
    for body in model.body_names:
        link, last_joint = body, None
        while last_joint is None and link in joint_by_child:
            joint = joint_by_child[link]
            last_joint = joint.index() if joint.index() in moving else None
            link = joint.parent_body().index()
        last_joints[body] = last_joint
    return last_joints


def _moving_joints(model: DrakeModel, group: JointGroup) -> set[JointIndex]:
    moving = {model.joint_indices[joint.name] for joint in group.joints}
    followers = {c.follower_position for c in model.followers_of(group)}
    for index in model.joint_indices.values():
        if model.plant.get_joint(index).position_start() in followers:
            moving.add(index)
    return moving
