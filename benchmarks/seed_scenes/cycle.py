"""Picking and placing: approach, attach, retreat, approach, let go, retreat."""

import numpy as np

import planning
from benchmarks.seed_scenes.leg import Leg
from planning.domain.request.deadline import Deadline

_EXACT = np.zeros(3)
_FROM_ABOVE = np.array([0.0, 0.0, -0.1])


def _down_to(frame: str) -> planning.PoseGoal:
    target = planning.PoseTarget(planning.Pose.identity(), frame)
    return planning.PoseGoal((target,), "arm::tcp", _EXACT, _EXACT, approach=_FROM_ABOVE)


def _straight_to(frame: str) -> planning.LineGoal:
    return planning.LineGoal((planning.PoseTarget(planning.Pose.identity(), frame),), "arm::tcp")


# Where the tool goes, and what is done there. `above_pick` hangs on the part, in the hand as well.
STEPS = (
    (_down_to("pick"), (planning.AttachObject("part", "arm::tcp"),)),
    (_straight_to("above_pick"), ()),
    (_down_to("place"), (planning.DetachObject("part"),)),
    (_straight_to("above_place"), ()),
)


def pick_and_place(world: planning.World, seed: int, deadline: Deadline) -> tuple[Leg, ...]:
    """Carry out the cycle; every motion is planned in the scene that the ones before it left.

    Raises:
        PlanningFailure: One of the motions was not found.
    """
    legs: list[Leg] = []
    for goal, operations in STEPS:
        found = planning.plan(
            planning.PlanningProblem("arm", goal, seed=seed), world, deadline=deadline
        )
        legs.append(Leg(world, found))
        reached = planning.SetPositions("arm", tuple(found.goal_configuration.tolist()))
        world = planning.load_world(planning.edit_scene(world.scene, [reached, *operations]))
    return tuple(legs)
