"""Searches with one thing less in the way: which body, or which path constraint."""

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from planning.domain.request.deadline import Deadline
from planning.errors import DeadlineExceeded
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_search import PoseSearch
from planning.goals.ik.solve import solve_tool_goal
from planning.world.constraints.body_pairs import moved_bodies
from planning.world.constraints.compiled_constraint import CompiledConstraint
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# So many bodies are taken away, one at a time.
_NUM_BODIES = 4
# Of so many of the configurations that would do it is measured by how much a rule must give way.
_NUM_MEASURED = 32
# Told beyond what was measured [m or rad].
_SPARE = 1e-5


def sufficient_removal(
    world: World,
    query: GoalQuery,
    search: PoseSearch,
    rng: np.random.Generator,
    deadline: Deadline,
) -> dict[str, Any] | None:
    """Return the body without which there is a solution, as evidence; None if no single one does.

    Args:
        world: The scene, with the limits that the query's rules leave.
        query: The goal, whose lines none of its configurations has.
        search: What was found of those.
        rng: Of the seeds.
        deadline: When to stop asking.
    """
    options = replace(query.options, max_configurations=1)
    for body in _in_the_way(world, query, search)[:_NUM_BODIES]:
        margins = query.margins.without(body, world.drake.all_bodies)
        relaxed = replace(query, margins=margins, options=options)
        found = _solutions(world, relaxed, rng, deadline)
        if found:
            ((q, index, _),) = found
            return {"body": body, "pose_index": index, "positions": q.tolist()}
    return None


def sufficient_constraint_relaxations(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> list[dict[str, Any]]:
    """Return the path constraints of which each, if it gave way, would leave a solution.

    It would do to drop it, or to move its bound to the `value` that is told, which is the least
    that was found.

    Args:
        world: The scene, with its own limits.
        query: The goal, and the rules that no solution keeps.
        rng: Of the seeds.
        deadline: When to stop asking.
    """
    rules = query.rules
    entries: list[dict[str, Any]] = []
    for k, rule in enumerate(rules.rules if rules else ()):
        assert rules is not None  # noqa: S101  (there is one)
        others = rules.without(k)
        tight = world.limited(query.group, others.fixing(world.limits(query.group)))
        found = _solutions(tight, replace(query, rules=others), rng, deadline)
        if found:
            entries.append(min((_given_way(rule, *one) for one in found), key=_lack))
    return sorted(entries, key=lambda entry: entry["constraint"])


def _solutions(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> list[tuple[Array, int, Array]]:
    """Return some solutions, which of the goal's poses they reach, and all waypoints of each.

    None if the time runs out.
    """
    try:
        _, search = solve_tool_goal(world, query, rng, deadline)
    except DeadlineExceeded:
        return []
    rows, indices = search.found.rows[:_NUM_MEASURED], search.found.targets[:_NUM_MEASURED]
    judge = search.judge
    if judge is None:
        return [(q, int(i), q[None]) for q, i in zip(rows, indices, strict=True)]
    legs = judge.legs_of(rows, rows)
    return [
        (rows[k], int(indices[k]), np.concatenate([leg.positions for leg in legs[k].all]))
        for k in np.flatnonzero(judge.keep_rules(rows))
    ]


def _given_way(rule: CompiledConstraint, q: Array, index: int, waypoints: Array) -> dict[str, Any]:
    """Return by how much a rule would have to give way for a solution and its lines."""
    rows = np.concatenate([q[None], waypoints])
    readings = [rule.reading(row) for row in rows[~rule.are_kept(rows)]]
    worst = max(readings, key=lambda one: abs(one.value - one.bound))
    value = worst.value + float(np.copysign(_SPARE, worst.value - worst.bound))
    is_one = len({one.bound for one in readings}) == 1
    return {
        "constraint": rule.label,
        "value": value if is_one else None,
        "bound": worst.bound,
        "unit": worst.unit,
        **({"joint": worst.joint} if worst.joint else {}),
        "pose_index": index,
        "positions": q.tolist(),
    }


def _lack(entry: dict[str, Any]) -> float:
    return np.inf if entry["value"] is None else abs(entry["value"] - entry["bound"])


def _in_the_way(world: World, query: GoalQuery, search: PoseSearch) -> list[str]:
    """Return the bodies that the group does not move and that stop lines, most often first."""
    moved = moved_bodies(world.drake, query.group)
    pairs = [] if search.judge is None else search.judge.blocking_pairs
    still = [[body for body in pair if body not in moved] for pair in pairs]
    return [body for body, _ in Counter(own[0] for own in still if len(own) == 1).most_common()]
