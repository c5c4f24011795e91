"""Goal configurations of a goal: the single entry of the goals stage, used by plans and by /ik."""

from dataclasses import replace

import numpy as np

from planning.domain.goals.goal import (
    ConfigurationGoal,
    GoalPredicate,
    JointGoal,
    LineGoal,
    PoseGoal,
    RegionGoal,
    RelativeGoal,
)
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.request.deadline import Deadline
from planning.errors import ProblemInvalid
from planning.goals.diagnosis.collision_tally import count_collisions
from planning.goals.diagnosis.goal_failure import goal_failure
from planning.goals.explicit import given_configurations
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_search import PoseSearch
from planning.goals.ik.solve import solve_tool_goal
from planning.goals.joint_metric import JointMetric
from planning.goals.lines.approach import with_moves
from planning.goals.predicate import accepted_by
from planning.goals.ranking import equivalents, nearest_first
from planning.goals.timeout import check_time
from planning.world.world import World

# Share of the time for goals that the search under path constraints may take.
_RULED_SHARE = 0.5
# Least number of solutions to find, even if fewer are requested: the nearest of them are returned.
_LEAST = 100


def find_goals(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> GoalConfigurations:
    """Return distinct, in-limit, collision-free goal configurations, nearest to the start first.

    Raises:
        GoalOutOfLimits: Every given configuration violates position limits.
        GoalInCollision: Configurations exist and all of them collide.
        GoalTooNear: All violate margins, and not all collide.
        GoalUnreachable: No configuration reaches a target pose.
        ApproachBlocked: No free configuration has a free approach and retreat.
        ProblemInvalid: A given configuration has the wrong number of positions, or the goal is a
            line goal.
        UnknownName: A frame or named configuration does not exist.
        DeadlineExceeded: Time ran out before a configuration was found.
        Canceled: Cancellation was requested.
    """
    deadline = _limited(deadline, query.options.time_limit)
    match query.goal:
        case LineGoal():
            message = "lines are not searched for; `trace_line` follows them"
            raise ProblemInvalid(message, {"field": "goal"})
        case PoseGoal() | RegionGoal() | RelativeGoal():
            return _reaching(world, query, rng, deadline)
        case GoalPredicate() as goal:
            return accepted_by(world, query, goal, rng, deadline)
        case JointGoal() | ConfigurationGoal() as goal:
            return given_configurations(world, query, goal, rng, deadline)


def _limited(deadline: Deadline, seconds: float | None) -> Deadline:
    """Return the earlier of the deadline and the goals' own time limit, which errors then name."""
    within = deadline.within(seconds)
    if seconds is None or within.at >= deadline.at:
        return deadline
    return replace(within, allowed=seconds)


def _reaching(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> GoalConfigurations:
    """Sample configurations that reach a tool goal.

    Under path constraints, configurations that satisfy them are searched for first, within the
    joint limits that the constraints leave. If none is found, configurations without the
    constraints are returned, so that a diagnosis can name the violated constraints.
    """
    tight, plain = world, query
    if query.rules is not None:
        tight = world.limited(query.group, query.rules.fixing(world.limits(query.group)))
        _, search = solve_tool_goal(tight, _widely(query), rng, deadline.share(_RULED_SHARE))
        if len(search.found):
            return _ranked(tight, query, search, deadline)
        check_time(tight, query, search, deadline)
        plain = replace(query, rules=None)
    aiming, search = solve_tool_goal(world, _widely(plain), rng, deadline)
    if not len(search.found):
        check_time(world, plain, search, deadline)
        raise goal_failure(tight, query, aiming, search, rng, deadline)
    return _ranked(world, plain, search, deadline)


def _widely(query: GoalQuery) -> GoalQuery:
    wanted = max(query.options.max_configurations, _LEAST)
    return replace(query, options=replace(query.options, max_configurations=wanted))


def _ranked(
    world: World, query: GoalQuery, search: PoseSearch, deadline: Deadline
) -> GoalConfigurations:
    """Return the solutions and their equivalents by full turns, nearest to the start first."""
    group, options = query.group, query.options
    metric = JointMetric.from_names(group, options.joint_weights)
    tally = count_collisions(world, query, search.colliding[: query.num_measured], deadline)
    rows, index = equivalents(group, world.limits(group), search.found.rows)
    turned = search.found.targets[index]
    funnel = search.funnel(tally.summary)
    if search.judge is not None:
        legs = search.judge.legs_of(search.found.rows[index], rows)
        return with_moves(query, world.limits(group), (rows, turned, legs), funnel)
    nearest = nearest_first(metric, query.start, rows, turned, options.max_configurations)
    return GoalConfigurations(*nearest, funnel)
