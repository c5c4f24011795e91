"""The nearest pose that a tool frame can take to one that it cannot."""

from itertools import islice
from typing import Any

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.solvers import SnoptSolver, SolverOptions

from planning.domain.joints import JointGroup
from planning.domain.report import NearestPose
from planning.goals.ik_program import ToolTarget
from planning.goals.seeds import seeds
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

_NUM_SEEDS = 12
# One radian of rotation weighs as much as this much translation [m].
_METRES_PER_RADIAN = 0.1


def nearest_pose(
    world: World, group: JointGroup, target: ToolTarget, start: Array, rng: np.random.Generator
) -> NearestPose:
    """Return the best of some local minima of translation^2 + (0.1 m * rotation)^2.

    Joint limits are kept; collisions are not looked at.
    """
    plant = world.drake.plant
    diagram_context = world.drake.diagram.CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(diagram_context)
    plant.SetPositions(context, world.state)
    moving = {world.drake.joint_indices[joint.name] for joint in group.joints}
    for index in world.drake.joint_indices.values():
        if index not in moving:
            plant.get_joint(index).Lock(context)
    ik = InverseKinematics(plant, context, with_joint_limits=True)
    frame = world.drake.frames[target.frame]
    x_wg = RigidTransform(target.pose.matrix)
    ik.AddPositionCost(plant.world_frame(), x_wg.translation(), frame, np.zeros(3), np.eye(3))
    # Drake's cost is c (1 - cos theta), about c theta^2 / 2.
    weight = 2 * _METRES_PER_RADIAN**2
    ik.AddOrientationCost(plant.world_frame(), x_wg.rotation(), frame, RotationMatrix(), weight)
    solver, options = SnoptSolver(), SolverOptions()
    options.SetOption(SnoptSolver.id(), "Major iterations limit", 200)
    indices = world.drake.position_indices(group)
    limits = world.limits(group)
    best: NearestPose | None = None
    for seed in islice(seeds(group, limits, start, rng), _NUM_SEEDS):
        guess = np.array(world.state)
        guess[indices] = seed
        result = solver.Solve(ik.prog(), guess, options)
        q = np.clip(result.GetSolution(ik.q())[indices], limits.lower, limits.upper)
        reached = world.frame_pose(target.frame, world.embed(group, q))
        translation, rotation = reached.distance(target.pose)
        found = NearestPose(reached, q, translation, rotation)
        if best is None or _cost(found) < _cost(best):
            best = found
    assert best is not None  # noqa: S101  (there is at least one seed)
    return best


def _cost(found: NearestPose) -> float:
    return found.translation_error**2 + (_METRES_PER_RADIAN * found.rotation_error) ** 2
