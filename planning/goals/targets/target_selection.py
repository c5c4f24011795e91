"""TargetSelection: target poses that the IK search of a goal samples, and acceptance of results."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.goals.goal import PoseBall, PoseGoal, RegionGoal, RelativeGoal
from planning.goals.goal_query import GoalQuery
from planning.goals.targets.ball_target import BallTarget
from planning.goals.targets.region_samples import RegionSamples
from planning.goals.targets.region_target import RegionTarget
from planning.goals.targets.target_samples import TargetSamples, all_seed_target_pairs
from planning.goals.targets.tool_target import (
    ToolTarget,
    relative_target,
    tool_targets,
    weight_axes,
)
from planning.goals.targets.workspace_bound import workspace_bound
from planning.world.world import World

# Finite bound for the solvers, which accept no infinite box; larger than any arm [m].
_FINITE_BOUND = 1e3


@dataclass(frozen=True)
class TargetSelection:
    """Target samples for the IK search of a goal, and the targets that its solutions must meet.

    Attributes:
        accepted: Target that accepts a solution, for each of the goal's poses.
        first_phase: Target samples of the first phase, block by block.
        fallback: Target samples of the fallback if the first phase finds nothing; None for no
            fallback.
        first_phase_fraction: Share of all trials before the fallback.
    """

    accepted: list[ToolTarget] | list[RegionTarget] | list[BallTarget]
    first_phase: Iterable[TargetSamples]
    fallback: TargetSamples | None = None
    first_phase_fraction: float = 1.0


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
            return TargetSelection(targets, (all_seed_target_pairs(targets),))
        case RegionGoal():
            region_targets = tool_targets(world, group, goal, start)
            regions = [
                RegionTarget(one.frame, one.pose, one.position_tolerance, one.rotation_tolerance)
                for one in region_targets
            ]
            first_phase = _region_samples(world, query, regions, rng)
            bounded = [
                replace(one, position_tolerance=np.minimum(one.position_tolerance, _FINITE_BOUND))
                for one in region_targets
            ]
            return TargetSelection(regions, first_phase, all_seed_target_pairs(bounded), 2 / 3)
        case PoseGoal(ball=PoseBall() as ball):
            full = world.embed(group, start)
            balls = [
                BallTarget(
                    one.frame,
                    one.pose,
                    ball.weights,
                    ball.tolerance,
                    weight_axes(world, full, ball, one.pose),
                )
                for one in tool_targets(world, group, goal, start)
            ]
            inscribed = all_seed_target_pairs([ball.inscribed_target for ball in balls])
            return TargetSelection(
                balls, _region_samples(world, query, balls, rng), inscribed, 2 / 3
            )
        case PoseGoal():
            targets = tool_targets(world, group, goal, start)
            return TargetSelection(targets, (all_seed_target_pairs(targets),))
        case _:
            message = f"{type(goal).__name__} is not reached by a tool frame"
            raise TypeError(message)


def _region_samples(
    world: World,
    query: GoalQuery,
    regions: Sequence[RegionTarget | BallTarget],
    rng: np.random.Generator,
) -> RegionSamples:
    workspace = workspace_bound(world, query.group, regions[0].frame)
    return RegionSamples(regions, workspace, query.options.max_trials, rng)
