"""Path constraints of a plan: checks of start and goal configurations, and constrained search."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.goals.goal import (
    ConfigurationGoal,
    JointGoal,
    PoseGoal,
    RegionGoal,
    RelativeGoal,
)
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.request.constraint import PathConstraint
from planning.domain.request.deadline import Deadline
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.errors import GoalViolatesConstraint, NoPathFound, StartViolatesConstraint
from planning.goals.diagnosis.suggestions import suggest_reachable_without_constraint
from planning.goals.explicit import suggest_nearest_joints
from planning.goals.goal_query import GoalQuery
from planning.search.locked_joints import search_with_locked_joints
from planning.search.ompl.projected_space import Residual
from planning.search.query import can_project
from planning.search.request import SearchResult, SearchTask
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import CollisionChecker, World

# RRTConnect's default step [rad or m].
_DEFAULT_STEP = 0.5
# Largest number of states that an attempt by sampling, and one by projection, checks in the first
# round on a set of measure zero, and growth factor of both per round. A projected state takes about
# a hundred times as long.
_FIRST_SAMPLED_STATES, _FIRST_PROJECTED_STATES, _GROWTH_FACTOR = 200_000, 1_000, 4
# Largest number of violations in a message; the evidence has all.
_MAX_NAMED_VIOLATIONS = 3


def compile_constraints(
    world: World,
    group: JointGroup,
    constraints: tuple[PathConstraint, ...],
    start: Float64[np.ndarray, " nq"],
) -> PathConstraints | None:
    """Return the path constraints compiled for a start, shape (nq,); None if there are none.

    Raises:
        UnknownName: A body, frame or joint does not exist.
        ProblemInvalid: A number of a constraint is invalid.
        StartViolatesConstraint: The start violates a constraint.
    """
    if not constraints:
        return None
    path_constraints = PathConstraints.compiled(world, group, constraints, start)
    violations = path_constraints.violations(start)
    if violations:
        named = "; ".join(map(_describe_violation, violations[:_MAX_NAMED_VIOLATIONS]))
        message = f"the start violates {named}"
        raise StartViolatesConstraint(message, {"violations": violations})
    return path_constraints


def filter_goals(
    world: World, query: GoalQuery, goals: GoalConfigurations, seed: int, deadline: Deadline
) -> GoalConfigurations:
    """Return the goal configurations that satisfy the path constraints, linear moves included.

    Raises:
        GoalViolatesConstraint: None does; evidence has the nearest feasible configuration or pose,
            and sufficient relaxations.
    """
    constraints, goal = query.constraints, query.goal
    if constraints is None:
        return goals
    violations_by_row = [
        _violations(constraints, goals, row) for row in range(len(goals.positions))
    ]
    rows = [row for row, violations in enumerate(violations_by_row) if not violations]
    if not rows:
        statistics = _violation_statistics(violations_by_row)
        evidence, suggestion = dict[str, Any](), ""
        rng = np.random.default_rng(seed)
        match goal:
            case JointGoal() | ConfigurationGoal():
                evidence, suggestion = suggest_nearest_joints(world, query, goal, rng, deadline)
            case PoseGoal() | RegionGoal() | RelativeGoal():
                evidence, suggestion = suggest_reachable_without_constraint(
                    world, query, goals.positions, rng, deadline
                )
            case _:
                pass
        message = _violation_message(len(violations_by_row), statistics) + suggestion
        raise GoalViolatesConstraint(message, {"violations": statistics, **evidence})
    num_violating = goals.funnel.num_goals_violating + len(violations_by_row) - len(rows)
    return GoalConfigurations(
        goals.positions[rows],
        tuple(goals.target_indices[row] for row in rows),
        replace(goals.funnel, num_goals_violating=num_violating),
        tuple(goals.moves[row] for row in rows if goals.moves),
    )


def search_constrained(
    constraints: PathConstraints,
    limits: JointLimits,
    checker: CollisionChecker,
    task: SearchTask,
    deadline: Deadline,
    watch: Stopwatch,
) -> SearchResult:
    """Search for a path that satisfies path constraints.

    Raises:
        NoPathFound: The planner ended without an exact solution.
        DeadlineExceeded: The time ran out without a path.
        Canceled: Cancellation was requested.
    """
    options = task.options
    if "RRTConnect" in options.planners and constraints.suggested_step < _DEFAULT_STEP:
        parameters = {"range": constraints.suggested_step, **options.parameters}
        options = replace(options, parameters=parameters)
    constrained_task = replace(task, options=options)
    oracle = constraints.oracle(checker)

    def run_search(task: SearchTask) -> SearchResult:
        return search_with_locked_joints(
            constraints.group, constraints.locked, limits, oracle, task, deadline, watch
        )

    if constraints.residual is None or not can_project(constraints.group, options):
        return run_search(constrained_task)
    return _alternate_sampling_and_projection(run_search, constrained_task, constraints.residual)


def _alternate_sampling_and_projection(
    run_search: Callable[[SearchTask], SearchResult], task: SearchTask, residual: Residual
) -> SearchResult:
    """Search by sampling and by projection in turn, each with more states in every round.

    Which of them is quicker depends on the problem. Attempts are limited by numbers of states, not
    by seconds, so that the result is reproducible.

    Raises:
        NoPathFound: Both ended by themselves without a solution, or there can be none.
        DeadlineExceeded: The time ran out.
        Canceled: Cancellation was requested.
    """
    num_sampled_states, num_projected_states = _FIRST_SAMPLED_STATES, _FIRST_PROJECTED_STATES
    while True:
        num_given_up = 0
        for limited_task in (
            replace(task, max_checked_states=num_sampled_states),
            replace(task, max_checked_states=num_projected_states, residual=residual),
        ):
            try:
                return run_search(limited_task)
            except NoPathFound as failure:
                num_given_up += failure.evidence.get("num_given_up", 0)
                if "reason" in failure.evidence or (
                    limited_task.residual is not None and not num_given_up
                ):
                    raise
            task = replace(task, roadmap=None)
        num_sampled_states *= _GROWTH_FACTOR
        num_projected_states *= _GROWTH_FACTOR


def _violations(
    constraints: PathConstraints, goals: GoalConfigurations, row: int
) -> list[dict[str, Any]]:
    """Return the violations of a goal configuration, or else of the first violating waypoint."""
    waypoints = [move.positions for move in goals.moves[row].all] if goals.moves else []
    for q in np.concatenate([goals.positions[row : row + 1], *waypoints]):
        violations = constraints.violations(q)
        if violations:
            return violations
    return []


def _violation_message(count: int, statistics: list[dict[str, Any]]) -> str:
    """Return the message of a failure in which all goal configurations violate constraints."""
    entries = statistics[:_MAX_NAMED_VIOLATIONS]
    if count == 1:
        descriptions = "; ".join(_describe_violation(entry["least"]) for entry in entries)
        return f"the goal configuration violates {descriptions}"
    descriptions = "; ".join(
        f"{entry['count']} violate {_describe_violation(entry['least'], ', at least by')}"
        for entry in entries
    )
    return f"all {count} goal configurations violate path constraints: {descriptions}"


def _describe_violation(violation: dict[str, Any], by: str = " by") -> str:
    """Return a constraint's index and kind and the amount of its violation, as text."""
    index, _, kind = str(violation["constraint"]).partition(": ")
    value, bound, unit = violation["value"], violation["bound"], violation["unit"]
    if unit == "1":
        return f"{index} ({kind}), which is false"
    at = f" at {violation['joint']}" if "joint" in violation else ""
    amount = f"{abs(value - bound):.4g} {unit}"
    return f"{index} ({kind}){by} {amount}{at} ({value:.4g} {unit}, bound {bound:.4g} {unit})"


def _violation_statistics(violations_by_row: list[list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """Return the number and the least of the violations of each constraint, most frequent first."""
    entries: dict[str, list[dict[str, Any]]] = {}
    for violation in (entry for violations in violations_by_row for entry in violations):
        entries.setdefault(violation["constraint"], []).append(violation)
    statistics = [
        {
            "constraint": label,
            "count": len(group),
            "least": min(group, key=lambda entry: abs(entry["value"] - entry["bound"])),
        }
        for label, group in entries.items()
    ]
    return sorted(statistics, key=lambda entry: -int(entry["count"]))
