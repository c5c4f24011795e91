"""Relaxed searches: goal configurations without one body, or without one path constraint."""

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.request.deadline import Deadline
from planning.errors import DeadlineExceeded
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_search import PoseSearch
from planning.goals.ik.solve import solve_tool_goal
from planning.world.constraints.body_pairs import moved_bodies
from planning.world.constraints.compiled_constraint import CompiledConstraint
from planning.world.world import World

# Largest number of bodies removed, one at a time.
_NUM_BODIES = 4
# Largest number of solutions for which the violation of a constraint is measured.
_NUM_MEASURED = 32
# Reserve added to the measured violation [m or rad].
_RESERVE = 1e-5


def sufficient_removal(
    world: World,
    query: GoalQuery,
    search: PoseSearch,
    rng: np.random.Generator,
    deadline: Deadline,
) -> dict[str, Any] | None:
    """Return a body whose removal makes the goal feasible, as evidence; None if no single one does.

    Args:
        world: Loaded scene, with the joint limits under the query's path constraints.
        query: Goal query, none of whose configurations has a free approach and retreat.
        search: Finished search with the blocked solutions.
        rng: Random generator of the seeds.
        deadline: Time limit of the searches.
    """
    options = replace(query.options, max_configurations=1)
    for body in _blocking_bodies(world, query, search)[:_NUM_BODIES]:
        margins = query.margins.ignoring(body, world.drake.all_bodies)
        relaxed = replace(query, margins=margins, options=options)
        solutions = _solutions(world, relaxed, rng, deadline)
        if solutions:
            ((q, index, _),) = solutions
            return {"body": body, "pose_index": index, "positions": q.tolist()}
    return None


def sufficient_constraint_relaxations(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> list[dict[str, Any]]:
    """Return the path constraints that are sufficient to relax, each alone, as evidence.

    A constraint may be dropped, or its bound moved to the `value` of the entry, which is the
    smallest sufficient change found.

    Args:
        world: Loaded scene, with its own limits.
        query: Goal query, whose path constraints no solution satisfies.
        rng: Random generator of the seeds.
        deadline: Time limit of the searches.
    """
    constraints = query.constraints
    entries: list[dict[str, Any]] = []
    for k, constraint in enumerate(constraints.constraints if constraints else ()):
        assert constraints is not None  # noqa: S101  (there is one)
        remaining = constraints.without(k)
        constrained_world = world.with_limits(
            query.group, remaining.limits_with_locks(world.limits(query.group))
        )
        solutions = _solutions(
            constrained_world, replace(query, constraints=remaining), rng, deadline
        )
        if solutions:
            relaxations = [_constraint_relaxation(constraint, *one) for one in solutions]
            entries.append(min(relaxations, key=_bound_change))
    return sorted(entries, key=lambda entry: entry["constraint"])


def _solutions(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> list[tuple[Array, int, Array]]:
    """Return some solutions, the index of the goal's pose, and all waypoints of the lines of each.

    The list is empty if the time runs out.
    """
    try:
        _, search = solve_tool_goal(world, query, rng, deadline)
    except DeadlineExceeded:
        return []
    rows, indices = search.solutions.rows[:_NUM_MEASURED], search.solutions.targets[:_NUM_MEASURED]
    checker = search.checker
    if checker is None:
        return [(q, int(i), q[None]) for q, i in zip(rows, indices, strict=True)]
    moves = checker.moves_of(rows, rows)
    return [
        (rows[k], int(indices[k]), np.concatenate([move.positions for move in moves[k].all]))
        for k in np.flatnonzero(checker.moves_satisfy_constraints(rows))
    ]


def _constraint_relaxation(
    constraint: CompiledConstraint, q: Array, index: int, waypoints: Array
) -> dict[str, Any]:
    """Return the relaxation of a path constraint that a solution and its lines need."""
    rows = np.concatenate([q[None], waypoints])
    values = [constraint.value(row) for row in rows[~constraint.are_satisfied(rows)]]
    worst = max(values, key=lambda one: abs(one.value - one.bound))
    value = worst.value + float(np.copysign(_RESERVE, worst.value - worst.bound))
    is_single_bound = len({one.bound for one in values}) == 1
    return {
        "constraint": constraint.label,
        "value": value if is_single_bound else None,
        "bound": worst.bound,
        "unit": worst.unit,
        **({"joint": worst.joint} if worst.joint else {}),
        "pose_index": index,
        "positions": q.tolist(),
    }


def _bound_change(entry: dict[str, Any]) -> float:
    return np.inf if entry["value"] is None else abs(entry["value"] - entry["bound"])


def _blocking_bodies(world: World, query: GoalQuery, search: PoseSearch) -> list[str]:
    """Return the bodies not moved by the group that block lines, most frequent first."""
    moved = moved_bodies(world.drake, query.group)
    pairs = [] if search.checker is None else search.checker.blocking_pairs
    static_bodies = [[body for body in pair if body not in moved] for pair in pairs]
    counts = Counter(bodies[0] for bodies in static_bodies if len(bodies) == 1)
    return [body for body, _ in counts.most_common()]
