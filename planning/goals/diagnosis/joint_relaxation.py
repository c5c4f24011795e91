"""Relaxation of a joint goal: limits, obstacles, constraints or margin that make it infeasible."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.body_pair import BodyPair
from planning.goals.goal_query import GoalQuery
from planning.goals.start_validation import limit_violations, pair_evidence
from planning.world.constraints.body_pairs import moved_bodies
from planning.world.world import World

# Margins tried, as shares of the least distance, and their reserve below that distance [m].
_MARGIN_FRACTIONS, _MARGIN_RESERVE = (1.0, 0.9, 0.5, 0.0), 1e-6


def joint_goal_relaxation(
    world: World, query: GoalQuery, rows: Float64[np.ndarray, "n nq"]
) -> dict[str, Any]:
    """Return the violations of the least infeasible row and sufficient relaxations, as evidence.

    Least infeasible is the row with the fewest kinds of violations (limits, body pairs, path
    constraints), and of those the one with the smallest collision depth.

    Args:
        world: Loaded scene, with its own limits.
        query: Goal query.
        rows: Goal configurations.
    """
    violations = [_violations(world, query, q) for q in rows]
    best = min(
        range(len(violations)),
        key=lambda k: (_num_violated_kinds(violations[k]), _depth(violations[k]), k),
    )
    limits, pairs, constraints = violations[best]
    return {
        "goal_index": best,
        "positions": rows[best].tolist(),
        "limits": limits,
        "obstacles": pair_evidence(pairs, query.margins),
        "constraints": constraints,
        "remove": _bodies_to_remove(moved_bodies(world.drake, query.group), pairs),
        "margin": _sufficient_margin(world, query, rows[best], pairs),
    }


type _Violations = tuple[list[dict[str, Any]], tuple[BodyPair, ...], list[dict[str, Any]]]


def _violations(world: World, query: GoalQuery, q: Float64[np.ndarray, " nq"]) -> _Violations:
    outside = limit_violations(world.limits(query.group), query.group, q)
    pairs = world.violations(query.group, q, query.margins)
    violated_constraints = [] if query.constraints is None else query.constraints.violations(q)
    return outside, pairs, violated_constraints


def _num_violated_kinds(violations: _Violations) -> int:
    return sum(bool(some) for some in violations)


def _depth(violations: _Violations) -> float:
    """Return the largest penetration depth of a pair [m], regardless of its margin."""
    return max((-pair.distance for pair in violations[1]), default=-np.inf)


def _bodies_to_remove(moved: set[str], pairs: Iterable[BodyPair]) -> list[str] | None:
    """Return the bodies whose removal leaves no pair colliding; None for a self-collision.

    Of a pair with one body that the group moves, the other body is removed. Of a pair that the
    group does not move, which collides at every q, the second body is removed, unless one of them
    is already.
    """
    removed: dict[str, None] = {}
    static_pairs: list[tuple[str, str]] = []
    for pair in pairs:
        static_bodies = [body for body in pair.bodies if body not in moved]
        if not static_bodies:
            return None
        if len(static_bodies) == 1:
            removed[static_bodies[0]] = None
        else:
            static_pairs.append(pair.bodies)
    for bodies in static_pairs:
        if not set(bodies) & set(removed):
            removed[bodies[1]] = None
    return sorted(removed)


def _sufficient_margin(
    world: World,
    query: GoalQuery,
    q: Float64[np.ndarray, " nq"],
    pairs: tuple[BodyPair, ...],
) -> float | None:
    """Return the largest of a few request margins at which q is free [m]; None if there is none.

    Margins of the scene for specific pairs stay as they are.
    """
    pair_margins = query.margins.by_pair
    if not pairs or min(pair.distance for pair in pairs) < 0:
        return None
    if any(tuple(sorted(pair.bodies)) in pair_margins for pair in pairs):
        return None
    max_margin = min(pair.distance for pair in pairs) - _MARGIN_RESERVE
    for fraction in _MARGIN_FRACTIONS:
        margin = max(fraction * max_margin, 0.0)
        if world.collision_oracle(query.group, world.margins(margin)).is_free(q):
            return margin
    return None
