"""TargetSelection: how the solutions of a goal are looked for, and what counts as reached."""

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

# Wide enough for any arm; solvers take no infinite box [m].
_WIDE = 1e3


@dataclass(frozen=True)
class TargetSelection:
    """How the solutions of a goal are looked for.

    Attributes:
        accepted: What is accepted as each of the goal's poses.
        first: What to aim at, one after another.
        then: What to aim at if that finds nothing; None if there is nothing else.
        share: The part of all trials that comes before.
    """

    accepted: list[ToolTarget] | list[RegionTarget] | list[BallTarget]
    first: Iterable[TargetSamples]
    then: TargetSamples | None = None
    share: float = 1.0


def select_targets(world: World, query: GoalQuery, rng: np.random.Generator) -> TargetSelection:
    """Return how to look for solutions of a goal that is reached by a tool frame.

    A region is aimed at pose by pose, so that solutions are spread over it. If nothing comes of
    that, because little of it can be reached, the solver may end anywhere in it.

    Raises:
        UnknownName: A frame does not exist.
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
