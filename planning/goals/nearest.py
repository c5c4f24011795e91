"""The nearest pose that a tool frame can take to one that it cannot."""

from typing import Any

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from planning.domain.joints import JointGroup
from planning.domain.report import NearestPose
from planning.goals.group_program import GroupProgram
from planning.goals.seeds import Seeds
from planning.goals.tool_target import ToolTarget
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

_NUM_SEEDS = 12
_MAJOR_ITERATIONS = 200
# One radian of rotation weighs as much as this much translation [m].
_METRES_PER_RADIAN = 0.1


def nearest_pose(
    world: World, group: JointGroup, target: ToolTarget, start: Array, rng: np.random.Generator
) -> NearestPose:
    """Return the best of some local minima of translation^2 + (0.1 m * rotation)^2.

    Joint limits are kept; collisions are not looked at.
    """
    program = GroupProgram(world, group, _MAJOR_ITERATIONS)
    frame, origin = world.drake.frames[target.frame], world.drake.plant.world_frame()
    x_wg = RigidTransform(target.pose.matrix)
    program.ik.AddPositionCost(origin, x_wg.translation(), frame, np.zeros(3), np.eye(3))
    # Drake's cost is c (1 - cos theta), about c theta^2 / 2.
    weight = 2 * _METRES_PER_RADIAN**2
    program.ik.AddOrientationCost(origin, x_wg.rotation(), frame, RotationMatrix(), weight)
    limits = world.limits(group)
    best: NearestPose | None = None
    for seed in Seeds(group, limits, start, rng).take(_NUM_SEEDS):
        q = np.clip(program.solve(seed), limits.lower, limits.upper)
        reached = world.frame_pose(target.frame, world.embed(group, q))
        translation, rotation = reached.distance(target.pose)
        found = NearestPose(reached, q, translation, rotation)
        if best is None or _cost(found) < _cost(best):
            best = found
    assert best is not None  # noqa: S101  (there is at least one seed)
    return best


def _cost(found: NearestPose) -> float:
    return found.translation_error**2 + (_METRES_PER_RADIAN * found.rotation_error) ** 2
