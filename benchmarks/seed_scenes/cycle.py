"""Picking and placing: approach, attach, retreat, transfer, place, let go, retreat."""

import numpy as np

import planning
from benchmarks.seed_scenes.leg import Leg
from planning.domain.deadline import Deadline

# Where the tool goes, and what is done there. `above_pick` hangs on the part, in the hand as well.
STEPS = (
    ("above_pick", ()),
    ("pick", (planning.AttachObject("part", "arm::tcp"),)),
    ("above_pick", ()),
    ("above_place", ()),
    ("place", (planning.DetachObject("part"),)),
    ("above_place", ()),
)


def pick_and_place(world: planning.World, seed: int, deadline: Deadline) -> tuple[Leg, ...]:
    """Carry out the cycle; every motion is planned in the scene that the ones before it left.

    Raises:
        PlanningFailure: One of the motions was not found.
    """
    legs: list[Leg] = []
    for frame, operations in STEPS:
        target = planning.PoseTarget(planning.Pose.identity(), frame)
        goal = planning.PoseGoal((target,), "arm::tcp", np.zeros(3), np.zeros(3))
        found = planning.plan(
            planning.PlanningProblem("arm", goal, seed=seed), world, deadline=deadline
        )
        legs.append(Leg(world, found))
        reached = planning.SetPositions("arm", tuple(found.goal_configuration.tolist()))
        world = planning.load_world(planning.edit_scene(world.scene, [reached, *operations]))
    return tuple(legs)
