"""Aims: what the solver is sent to, trial by trial, and what counts as reached."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Int64

from planning.domain.goal import PoseGoal, RegionGoal, RelativeGoal
from planning.goals.goal_query import GoalQuery
from planning.goals.reach_ball import reach_ball
from planning.goals.region_target import RegionTarget
from planning.goals.tool_target import ToolTarget, relative_target, tool_targets
from planning.world.world import World

type Indices = np.ndarray[Any, np.dtype[np.int64]]

# Wide enough for any arm; solvers take no infinite box [m].
_WIDE = 1e3


@dataclass(frozen=True)
class Aims:
    """Some targets of one tool frame.

    Attributes:
        targets: What the solver is given.
        poses: Which of the goal's poses each target stands for, shape (num_targets,).
        targets_per_seed: How many trials a seed is used for, each with the next target.
    """

    targets: list[ToolTarget]
    poses: Int64[np.ndarray, " num_targets"]
    targets_per_seed: int

    def trials(self, first: int, count: int) -> tuple[Indices, Indices]:
        """Return which seed and which target each of some trials takes."""
        numbers = np.arange(first, first + count)
        return numbers // self.targets_per_seed, numbers % len(self.poses)


@dataclass(frozen=True)
class Aiming:
    """How the solutions of a goal are looked for.

    Attributes:
        accepted: What is accepted as each of the goal's poses.
        first: What to aim at.
        then: What to aim at if that finds nothing; None if there is nothing else.
        share: The part of all trials that comes before.
    """

    accepted: list[ToolTarget] | list[RegionTarget]
    first: Aims
    then: Aims | None = None
    share: float = 1.0


def aiming_of(world: World, query: GoalQuery, rng: np.random.Generator) -> Aiming:
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
            return Aiming(targets, _every_seed(targets))
        case RegionGoal():
            whole = tool_targets(world, group, goal, start)
            regions = [
                RegionTarget(one.frame, one.pose, one.position_tolerance, one.rotation_tolerance)
                for one in whole
            ]
            first = _samples(world, query, regions, rng)
            bounded = [
                replace(one, position_tolerance=np.minimum(one.position_tolerance, _WIDE))
                for one in whole
            ]
            return Aiming(regions, first, _every_seed(bounded), 2 / 3)
        case PoseGoal():
            targets = tool_targets(world, group, goal, start)
            return Aiming(targets, _every_seed(targets))
        case _:
            message = f"{type(goal).__name__} is not reached by a tool frame"
            raise TypeError(message)


def _every_seed(targets: list[ToolTarget]) -> Aims:
    return Aims(targets, np.arange(len(targets)), len(targets))


def _samples(
    world: World, query: GoalQuery, regions: list[RegionTarget], rng: np.random.Generator
) -> Aims:
    """Return exact poses in the regions, in turn, one for every trial."""
    reach = reach_ball(world, query.group, regions[0].frame)
    count = -(-query.options.max_trials // len(regions))
    drawn = [region.samples(count, reach, rng) for region in regions]
    exact = np.zeros(3)
    targets = [
        ToolTarget(region.frame, poses[i], exact, exact)
        for i in range(count)
        for region, poses in zip(regions, drawn, strict=True)
    ]
    return Aims(targets, np.arange(len(targets)) % len(regions), 1)
