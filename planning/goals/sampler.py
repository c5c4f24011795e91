"""Goal configurations of a goal: the stage's one entry, shared by plans and by /ik."""

import logging
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from planning.domain.deadline import Deadline
from planning.domain.goal import (
    ConfigurationGoal,
    GoalPredicate,
    JointGoal,
    LineGoal,
    PoseGoal,
    RegionGoal,
    RelativeGoal,
)
from planning.domain.goal_configurations import GoalConfigurations
from planning.domain.joints import JointGroup
from planning.errors import ProblemInvalid
from planning.goals.aims import Aiming, aiming_of
from planning.goals.given import given_configurations
from planning.goals.goal_query import GoalQuery
from planning.goals.joint_metric import JointMetric
from planning.goals.leg_judge import leg_judge, with_legs
from planning.goals.pose_search import PoseSearch
from planning.goals.pose_solvers import DrakePoseSolver, PoseSolver, kernel_pose_solver
from planning.goals.predicate_search import accepted_by
from planning.goals.ranking import Distinct, equivalents, nearest_first
from planning.goals.refusal import refusal
from planning.goals.tally import tallied
from planning.goals.tool_target import ToolTarget
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Of the time for goals under rules, what the search for those that keep them may take.
_RULED_SHARE = 0.5

_LOG = logging.getLogger(__name__)


def find_goals(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> GoalConfigurations:
    """Return every distinct, in-limit, free goal configuration, nearest to the start first.

    Raises:
        GoalOutOfLimits: Every given configuration violates position limits.
        GoalInCollision: Configurations exist and all of them collide.
        GoalUnreachable: No configuration reaches a target pose.
        ProblemInvalid: A given configuration has the wrong count.
        UnknownName: A frame or named configuration does not exist.
        DeadlineExceeded: Time ran out before a configuration was found.
        Canceled: Somebody asked for the end.
    """
    match query.goal:
        case LineGoal():
            message = "lines are not searched for; `trace_path` follows them"
            raise ProblemInvalid(message, {"field": "goal"})
        case PoseGoal() | RegionGoal() | RelativeGoal():
            return _reaching(world, query, rng, deadline)
        case GoalPredicate() as goal:
            return accepted_by(world, query, goal, rng, deadline)
        case JointGoal() | ConfigurationGoal() as goal:
            return given_configurations(world, query, goal, rng, deadline)


def _reaching(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> GoalConfigurations:
    """Sample configurations that reach a pose.

    Under rules those that keep them are looked for first, within the limits that the rules leave.
    If there is none, the answer is that without rules, so that it can be said what they violate.
    """
    tight, plain = world, query
    if query.rules is not None:
        tight = world.limited(query.group, query.rules.fixing(world.limits(query.group)))
        _, search = _searched(tight, query, rng, deadline.share(_RULED_SHARE))
        if len(search.found):
            return _ranked(tight, query, search, deadline)
        deadline.check("goals")
        plain = replace(query, rules=None)
    aiming, search = _searched(world, plain, rng, deadline)
    if not len(search.found):
        deadline.check("goals")
        raise refusal(tight, query, aiming, search, rng, deadline)
    return _ranked(world, plain, search, deadline)


def _searched(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> tuple[Aiming, PoseSearch]:
    """Search, by the kernel if there is one, and let Drake verify what it finds.

    Drake answers alone if it refutes a single one of the kernel's.
    """
    group = query.group
    aiming = aiming_of(world, query, rng)
    state = rng.bit_generator.state
    solve = partial(kernel_pose_solver, world, group)
    search = _followed(world, query, aiming, solve, rng, deadline)
    if search is not None and not _are_met(world, group, aiming, search.found):
        _LOG.error("Drake refutes the kernel's inverse kinematics of %s", group.name)
        rng.bit_generator.state, search = state, None
    if search is None:
        drake = partial(DrakePoseSolver, world, group, deadline)
        search = _followed(world, query, aiming, drake, rng, deadline)
    assert search is not None  # noqa: S101  (Drake always has a solver)
    return aiming, search


def _ranked(
    world: World, query: GoalQuery, search: PoseSearch, deadline: Deadline
) -> GoalConfigurations:
    """Return what was found, whole turns included, nearest first."""
    group, options = query.group, query.options
    metric = JointMetric.from_names(group, options.joint_weights)
    tally = tallied(world, query, search.colliding[: query.num_measured], deadline)
    rows, index = equivalents(group, world.limits(group), search.found.rows)
    turned = search.found.targets[index]
    funnel = search.funnel(tally.summary)
    if search.judge is not None:
        legs = search.judge.legs_of(search.found.rows[index], rows)
        return with_legs(query, world.limits(group), (rows, turned, legs), funnel)
    nearest = nearest_first(metric, query.start, rows, turned, options.max_configurations)
    return GoalConfigurations(*nearest, funnel)


def _followed(
    world: World,
    query: GoalQuery,
    aiming: Aiming,
    solver_of: Callable[[list[ToolTarget]], PoseSolver | None],
    rng: np.random.Generator,
    deadline: Deadline,
) -> PoseSearch | None:
    """Return the search once it is over, None if there is no such solver."""
    solver = solver_of(aiming.first.targets)
    if solver is None:
        return None
    trials = query.options.max_trials
    judge = leg_judge(world, query, aiming.first.targets, deadline)
    search = PoseSearch(world, query, rng, deadline, judge)
    search.run(aiming.first, solver, int(np.ceil(aiming.share * trials)))
    aims = aiming.first
    if aiming.then is not None and not len(search.found):
        aims, solver = aiming.then, solver_of(aiming.then.targets) or solver
    search.run(aims, solver, trials)
    return search


def _are_met(world: World, group: JointGroup, aiming: Aiming, found: Distinct) -> bool:
    """Return whether Drake agrees that every solution reaches its target."""
    frame = aiming.accepted[0].frame
    reached = world.frame_poses(frame, world.embed(group, found.rows))
    return all(
        bool(target.are_met_by(reached[found.targets == i]).all())
        for i, target in enumerate(aiming.accepted)
    )
