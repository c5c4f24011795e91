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
from planning.goals.explicit import explicit_goal_configurations
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_search import PoseSearch
from planning.goals.ik.solve import solve_tool_goal
from planning.goals.joint_metric import JointMetric
from planning.goals.lines.approach_checker import with_moves
from planning.goals.predicate import find_predicate_goals
from planning.goals.ranking import full_turn_equivalents, nearest_first
from planning.goals.targets.target_selection import TargetSelection
from planning.goals.timeout import check_time
from planning.world.mechanics.idle_joints import idle_positions
from planning.world.world import World

# Share of the time for goals that the search under path constraints may take.
_CONSTRAINED_TIME_FRACTION = 0.5
# Least number of solutions to find, even if fewer are requested: the nearest of them are returned.
_MIN_SOLUTIONS = 100


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
    deadline = _with_time_limit(deadline, query.options.allowed_time)
    match query.goal:
        case LineGoal():
            message = "a line goal has no goal configurations; trace it with `trace_line`"
            raise ProblemInvalid(message, {"field": "goal"})
        case PoseGoal() | RegionGoal() | RelativeGoal():
            return _find_tool_goals(world, query, rng, deadline)
        case GoalPredicate() as goal:
            return find_predicate_goals(world, query, goal, rng, deadline)
        case JointGoal() | ConfigurationGoal() as goal:
            return explicit_goal_configurations(world, query, goal, rng, deadline)


def _with_time_limit(deadline: Deadline, seconds: float | None) -> Deadline:
    """Return the earlier of the deadline and the goals' own time limit, which errors then name."""
    limited = deadline.within(seconds)
    if seconds is None or limited.expires_at >= deadline.expires_at:
        return deadline
    return replace(limited, time_limit=seconds)


def _find_tool_goals(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> GoalConfigurations:
    """Sample configurations that reach a tool goal.

    Under path constraints, configurations that satisfy them are searched for first, within the
    joint limits that the constraints leave. If none is found, configurations without the
    constraints are returned, so that a diagnosis can name the violated constraints.
    """
    constrained_world, unconstrained = world, query
    if query.constraints is not None:
        constrained_world = world.with_limits(
            query.group, query.constraints.limits_with_locks(world.limits(query.group))
        )
        selection, search = solve_tool_goal(
            constrained_world,
            _with_min_solutions(query),
            rng,
            deadline.at_fraction(_CONSTRAINED_TIME_FRACTION),
        )
        if len(search.solutions):
            return _rank_solutions(constrained_world, query, selection, search, deadline)
        check_time(constrained_world, query, search, deadline)
        unconstrained = replace(query, constraints=None)
    selection, search = solve_tool_goal(world, _with_min_solutions(unconstrained), rng, deadline)
    if not len(search.solutions):
        check_time(world, unconstrained, search, deadline)
        raise goal_failure(constrained_world, query, selection, search, rng, deadline)
    return _rank_solutions(world, unconstrained, selection, search, deadline)


def _with_min_solutions(query: GoalQuery) -> GoalQuery:
    num_solutions = max(query.options.max_configurations, _MIN_SOLUTIONS)
    return replace(query, options=replace(query.options, max_configurations=num_solutions))


def _rank_solutions(
    world: World,
    query: GoalQuery,
    selection: TargetSelection,
    search: PoseSearch,
    deadline: Deadline,
) -> GoalConfigurations:
    """Return the solutions and their equivalents by full turns, nearest to the start first."""
    group, options = query.group, query.options
    metric = JointMetric.from_names(group, options.joint_weights)
    tally = count_collisions(world, query, search.colliding, query.num_measured, deadline)
    idle = idle_positions(world.drake, group, selection.accepted[0].frame)
    rows, index = full_turn_equivalents(group, world.limits(group), search.solutions.rows, idle)
    target_indices = search.solutions.targets[index]
    funnel = search.funnel(tally.summary)
    if search.checker is not None:
        moves = search.checker.moves_of(search.solutions.rows[index], rows)
        return with_moves(query, world.limits(group), (rows, target_indices, moves), funnel)
    nearest = nearest_first(metric, query.start, rows, target_indices, options.max_configurations)
    return GoalConfigurations(*nearest, funnel)
