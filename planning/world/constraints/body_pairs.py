"""Body pairs of a distance band: the pairs of bodies whose distance it constrains."""

import numpy as np

from planning.domain.request.constraint import DistanceBand
from planning.domain.robot.joints import JointGroup
from planning.errors import ProblemInvalid
from planning.world.collision.collision_pairs import collision_pairs_of
from planning.world.drake_model import DrakeModel
from planning.world.world import World


def banded_pairs(
    world: World, group: JointGroup, band: DistanceBand, field: str
) -> frozenset[tuple[str, str]]:
    """Return the pairs of a distance band that may collide, by full names in sorted order.

    Raises:
        ProblemInvalid: There is none.
    """
    moving = moved_bodies(world.drake, group)
    first = moving if band.bodies is None else set(band.bodies)
    second = set(world.drake.all_bodies) - first if band.to is None else set(band.to)
    pairs = {
        (min(a, b), max(a, b))
        for a, b in set(collision_pairs_of(world.drake).pair_names)
        if ((a in first and b in second) or (b in first and a in second))
        and (a in moving or b in moving)
    }
    if not pairs:
        message = f"{field}: no pair of these bodies moves relative to each other and is checked"
        raise ProblemInvalid(message, {"field": field})
    return frozenset(pairs)


def moved_bodies(model: DrakeModel, group: JointGroup) -> set[str]:
    """Return the full names of the bodies that the group moves, mimic joints included."""
    velocities = set(model.velocity_indices(group).tolist())
    velocities |= {c.follower_velocity for c in model.followers_of(group)}
    joints = [model.plant.get_joint(i) for i in model.plant.GetJointIndices()]
    moving = [
        joint.index()
        for joint in joints
        if velocities & set(np.arange(joint.num_velocities()) + joint.velocity_start())
    ]
    affected = model.plant.GetBodiesKinematicallyAffectedBy(moving)
    return {model.body_names[i] for i in affected if i in model.body_names}
