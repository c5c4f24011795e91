"""A plan under path constraints: its start, its goals, its search."""

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
from planning.goals.explicit import suggest_joints
from planning.goals.goal_query import GoalQuery
from planning.search.locked_joints import search_with_locked_joints
from planning.search.ompl.projected_space import Residual
from planning.search.query import can_project
from planning.search.request import SearchResult, SearchTask
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import CollisionJudge, World

# RRTConnect's steps where nothing else is asked for [rad or m].
_USUAL_STRIDE = 0.5
# How many states an attempt by sampling, and one by projection, may check in the first round where
# a path must keep to a thin set, and by how much more in every round that follows. A projected
# state takes some hundred times as long.
_SAMPLED_STATES, _PROJECTED_STATES, _MORE = 200_000, 1_000, 4
# Messages have no more of what is violated than that; the evidence has all.
_MOST_TOLD = 3


def compile_constraints(
    world: World,
    group: JointGroup,
    constraints: tuple[PathConstraint, ...],
    start: Float64[np.ndarray, " nq"],
) -> PathConstraints | None:
    """Return the rules that constraints make from a start, shape (nq,); None without any.

    Raises:
        UnknownName: A body, frame or joint does not exist.
        ProblemInvalid: A number makes no sense.
        StartViolatesConstraint: The start does.
    """
    if not constraints:
        return None
    rules = PathConstraints.compiled(world, group, constraints, start)
    violations = rules.violations(start)
    if violations:
        message = f"the start violates {'; '.join(map(_violated, violations[:_MOST_TOLD]))}"
        raise StartViolatesConstraint(message, {"violations": violations})
    return rules


def filter_goals(
    world: World, query: GoalQuery, goals: GoalConfigurations, seed: int, deadline: Deadline
) -> GoalConfigurations:
    """Return the goal configurations that keep the query's rules, on their lines too.

    Raises:
        GoalViolatesConstraint: None does; evidence has the nearest that does, and what would do.
    """
    rules, goal = query.rules, query.goal
    if rules is None:
        return goals
    found = [_violations(rules, goals, row) for row in range(len(goals.positions))]
    rows = [row for row, violations in enumerate(found) if not violations]
    if not rows:
        tally = _tally(found)
        evidence, words = dict[str, Any](), ""
        rng = np.random.default_rng(seed)
        match goal:
            case JointGoal() | ConfigurationGoal():
                evidence, words = suggest_joints(world, query, goal, rng, deadline)
            case PoseGoal() | RegionGoal() | RelativeGoal():
                evidence, words = suggest_reachable_without_constraint(
                    world, query, goals.positions, rng, deadline
                )
            case _:
                pass
        message = _refusal(len(found), tally) + words
        raise GoalViolatesConstraint(message, {"violations": tally, **evidence})
    return GoalConfigurations(
        goals.positions[rows],
        tuple(goals.target_indices[row] for row in rows),
        replace(goals.funnel, violating=goals.funnel.violating + len(found) - len(rows)),
        tuple(goals.legs[row] for row in rows if goals.legs),
    )


def search_constrained(
    rules: PathConstraints,
    limits: JointLimits,
    judge: CollisionJudge,
    task: SearchTask,
    deadline: Deadline,
    watch: Stopwatch,
) -> SearchResult:
    """Search for a path that keeps the rules.

    Raises:
        NoPathFound: The planner ended without an exact solution.
        DeadlineExceeded: The time ran out before there was any.
        Canceled: The end was asked for.
    """
    options = task.options
    if "RRTConnect" in options.planners and rules.stride < _USUAL_STRIDE:
        parameters = {"range": rules.stride, **options.parameters}
        options = replace(options, parameters=parameters)
    ruled = replace(task, options=options)
    oracle = rules.oracle(judge)

    def searched(task: SearchTask) -> SearchResult:
        return search_with_locked_joints(
            rules.group, rules.locked, limits, oracle, task, deadline, watch
        )

    if rules.residual is None or not can_project(rules.group, options):
        return searched(ruled)
    return _in_turns(searched, ruled, rules.residual)


def _in_turns(
    searched: Callable[[SearchTask], SearchResult], task: SearchTask, residual: Residual
) -> SearchResult:
    """Return what sampling finds or else projection, each with more states in every round.

    Which of them is the quicker depends on the problem, and counts, not seconds, end their turns.

    Raises:
        NoPathFound: Both ended by themselves without a solution, or there is none to look for.
        DeadlineExceeded: The time ran out.
        Canceled: The end was asked for.
    """
    sampled, projected = _SAMPLED_STATES, _PROJECTED_STATES
    while True:
        given_up = 0
        for part in (
            replace(task, most_states=sampled),
            replace(task, most_states=projected, residual=residual),
        ):
            try:
                return searched(part)
            except NoPathFound as fault:
                given_up += fault.evidence.get("num_given_up", 0)
                if "reason" in fault.evidence or (part.residual is not None and not given_up):
                    raise
            task = replace(task, roadmap=None)
        sampled, projected = _MORE * sampled, _MORE * projected


def _violations(
    rules: PathConstraints, goals: GoalConfigurations, row: int
) -> list[dict[str, Any]]:
    """Return what a goal configuration violates, or else the first waypoint of its lines."""
    along = [leg.positions for leg in goals.legs[row].all] if goals.legs else []
    for q in np.concatenate([goals.positions[row : row + 1], *along]):
        violations = rules.violations(q)
        if violations:
            return violations
    return []


def _refusal(count: int, tally: list[dict[str, Any]]) -> str:
    """Return why none of some goal configurations will do, as words."""
    told = tally[:_MOST_TOLD]
    if count == 1:
        words = "; ".join(_violated(entry["least"]) for entry in told)
        return f"the goal configuration violates {words}"
    words = "; ".join(
        f"{entry['count']} violate {_violated(entry['least'], ', the least by')}" for entry in told
    )
    return f"none of {count} goal configurations keeps the path constraints: {words}"


def _violated(violation: dict[str, Any], by: str = " by") -> str:
    """Return a constraint's index and kind, and by how much it is violated."""
    index, _, kind = str(violation["constraint"]).partition(": ")
    value, bound, unit = violation["value"], violation["bound"], violation["unit"]
    if unit == "1":
        return f"{index} ({kind}), which says no"
    at = f" at {violation['joint']}" if "joint" in violation else ""
    amount = f"{abs(value - bound):.4g} {unit}"
    return f"{index} ({kind}){by} {amount}{at} ({value:.4g} {unit}, bound {bound:.4g} {unit})"


def _tally(found: list[list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """Return for every constraint how many violate it and the least violation, worst first."""
    entries: dict[str, list[dict[str, Any]]] = {}
    for violation in (entry for violations in found for entry in violations):
        entries.setdefault(violation["constraint"], []).append(violation)
    tally = [
        {
            "constraint": label,
            "count": len(those),
            "least": min(those, key=lambda entry: abs(entry["value"] - entry["bound"])),
        }
        for label, those in entries.items()
    ]
    return sorted(tally, key=lambda entry: -int(entry["count"]))
