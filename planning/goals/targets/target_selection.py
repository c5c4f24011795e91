"""TargetSelection: target poses that the IK search of a goal samples, and acceptance of results."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.goals.goal import PoseBall, PoseGoal, RegionGoal, RelativeGoal
from planning.goals.goal_query import GoalQuery
from planning.goals.targets.ball_target import BallTarget
from planning.goals.targets.region_samples import RegionSamples
from planning.goals.targets.region_target import RegionTarget
from planning.goals.targets.target_samples import TargetSamples, every_seed
from planning.goals.targets.tool_target import ToolTarget, axes_of, relative_target, tool_targets
from planning.goals.targets.workspace_bound import workspace_bound
from planning.world.world import World

# Finite bound for the solvers, which accept no infinite box; larger than any arm [m].
_WIDE = 1e3


@dataclass(frozen=True)
class TargetSelection:
    """Target samples for the IK search of a goal, and the targets that its solutions must meet.

    Attributes:
        accepted: Target that accepts a solution, for each of the goal's poses.
        first: Target samples of the first phase, block by block.
        then: Target samples of the fallback if the first phase finds nothing; None for no fallback.
        share: Share of all trials before the fallback.
    """

    accepted: list[ToolTarget] | list[RegionTarget] | list[BallTarget]
    first: Iterable[TargetSamples]
    then: TargetSamples | None = None
    share: float = 1.0


def select_targets(world: World, query: GoalQuery, rng: np.random.Generator) -> TargetSelection:
    """Return the target selection of a tool goal.

    A region (or ball) is sampled by exact poses, so that solutions are spread over it. If that
    finds nothing, because little of it is reachable, the solver gets the region itself as its
    tolerance.

    Raises:
        UnknownName: A frame does not exist.
        TypeError: The goal is not reached by a tool frame.
    """
    group, goal, start = query.group, query.goal, query.start
    match goal:
        case RelativeGoal():
            targets = [relative_target(world, group, goal, start)]
            return TargetSelection(targets, (every_seed(targets),))
        case RegionGoal():
            whole = tool_targets(world, group, goal, start)
            regions = [
                RegionTarget(one.frame, one.pose, one.position_tolerance, one.rotation_tolerance)
                for one in whole
            ]
            first = _drawn(world, query, regions, rng)
            bounded = [
                replace(one, position_tolerance=np.minimum(one.position_tolerance, _WIDE))
                for one in whole
            ]
            return TargetSelection(regions, first, every_seed(bounded), 2 / 3)
        case PoseGoal(ball=PoseBall() as ball):
            full = world.embed(group, start)
            balls = [
                BallTarget(
                    one.frame,
                    one.pose,
                    ball.weights,
                    ball.tolerance,
                    axes_of(world, full, ball, one.pose),
                )
                for one in tool_targets(world, group, goal, start)
            ]
            inside = every_seed([ball.inside for ball in balls])
            return TargetSelection(balls, _drawn(world, query, balls, rng), inside, 2 / 3)
        case PoseGoal():
            targets = tool_targets(world, group, goal, start)
            return TargetSelection(targets, (every_seed(targets),))
        case _:
            message = f"{type(goal).__name__} is not reached by a tool frame"
            raise TypeError(message)


def _drawn(
    world: World,
    query: GoalQuery,
    regions: Sequence[RegionTarget | BallTarget],
    rng: np.random.Generator,
) -> RegionSamples:
    reach = workspace_bound(world, query.group, regions[0].frame)
    return RegionSamples(regions, reach, query.options.max_trials, rng)
