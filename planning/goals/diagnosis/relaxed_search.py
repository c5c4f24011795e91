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
_SPARE = 1e-5


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
    """Return the path constraints that are sufficient to relax, each alone, as evidence.

    A constraint may be dropped, or its bound moved to the `value` of the entry, which is the
    smallest sufficient change found.

    Args:
        world: Loaded scene, with its own limits.
        query: Goal query, whose path constraints no solution satisfies.
        rng: Random generator of the seeds.
        deadline: Time limit of the searches.
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
    """Return some solutions, the index of the goal's pose, and all waypoints of the lines of each.

    The list is empty if the time runs out.
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
    """Return the relaxation of a path constraint that a solution and its lines need."""
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
    """Return the bodies not moved by the group that block lines, most frequent first."""
    moved = moved_bodies(world.drake, query.group)
    pairs = [] if search.judge is None else search.judge.blocking_pairs
    still = [[body for body in pair if body not in moved] for pair in pairs]
    return [body for body, _ in Counter(own[0] for own in still if len(own) == 1).most_common()]
