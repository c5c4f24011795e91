"""solve_ik(): the goals stage by itself."""

from typing import Any

import numpy as np

from planning.domain.deadline import Deadline
from planning.domain.goal import PoseGoal
from planning.domain.options import IkOptions
from planning.domain.report import GoalConfigurations
from planning.goals.sampler import GoalQuery, find_goals
from planning.world.positions import require_positions
from planning.world.world import World


def solve_ik(  # noqa: PLR0913  (a question in full)
    world: World,
    group: str,
    goal: PoseGoal,
    *,
    deadline: Deadline,
    start: Any = None,
    options: IkOptions | None = None,
    margin: float | None = None,
    seed: int = 0,
) -> GoalConfigurations:
    """Return every distinct free configuration that reaches a pose goal, nearest first.

    Args:
        world: The scene, loaded.
        group: `robot` or `robot::group`.
        goal: The poses.
        deadline: When to stop looking.
        start: The group's q to be near to, shape (nq,); None for the scene's state.
        options: How hard to look.
        margin: Distance to keep [m]; None for the scene's.
        seed: Of the random seeds.

    Raises:
        GoalInCollision: Configurations reach a pose and all collide.
        GoalUnreachable: No configuration reaches a pose.
        UnknownName: A group or frame does not exist.
        ProblemInvalid: The start does not fit the group.
    """
    joints = world.group(group)
    given = world.positions(joints) if start is None else start
    q = require_positions(joints, given, "start")
    query = GoalQuery(joints, goal, q, world.margins(margin), options or IkOptions())
    return find_goals(world, query, np.random.default_rng(seed), deadline)
