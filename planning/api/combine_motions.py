"""combine_motions(): motions of several groups as one motion of the group that spans them."""

from collections.abc import Sequence

import numpy as np

from planning.api.certify_trajectory import validate_joints
from planning.domain.curves.combined import combined
from planning.domain.request.group_motion import CombinedMotion, GroupMotion
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.spanning_group import joined_name, validate_disjoint
from planning.errors import ProblemInvalid
from planning.world.world import World


def combine_motions(world: World, motions: Sequence[GroupMotion]) -> CombinedMotion:
    """Return motions of several groups as one, each at its own time.

    The polynomials are those of the given motions. Each group rests before its motion begins and
    after it has ended, and the combined motion ends when the last one ends. Nothing is proven of
    it: `certify_trajectory` of its group proves limits and margins with all of them moving.

    Args:
        world: Loaded scene.
        motions: Motions of groups without a common joint; at least one.

    Raises:
        UnknownName: There is no such group.
        ProblemInvalid: There is no motion, two groups have a joint in common, a motion is not one
            of its group's joints, or it begins at a negative or infinite time.
    """
    groups = groups_of(world, motions)
    for i, motion in enumerate(motions):
        if not (np.isfinite(motion.begin) and motion.begin >= 0):
            field = f"motions.{i}.begin"
            message = f"{field} must be a number of seconds, 0 or more, not {motion.begin}"
            raise ProblemInvalid(message, {"field": field})
    group = world.group(joined_name([one.name for one in groups]))
    trajectory = combined(
        [motion.trajectory for motion in motions], [motion.begin for motion in motions]
    )
    return CombinedMotion(group.name, trajectory)


def groups_of(world: World, motions: Sequence[GroupMotion]) -> list[JointGroup]:
    """Return the groups of motions; raises as `combine_motions`."""
    if not motions:
        message = "motions: at least one is needed"
        raise ProblemInvalid(message, {"field": "motions"})
    groups = [world.group(motion.group) for motion in motions]
    validate_disjoint([motion.group for motion in motions], groups)
    for i, (group, motion) in enumerate(zip(groups, motions, strict=True)):
        validate_joints(group, motion.trajectory, f"motions.{i}.trajectory")
    return groups
