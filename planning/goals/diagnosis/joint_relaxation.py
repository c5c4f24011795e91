"""Relaxation of a joint goal: limits, obstacles, constraints or margin that make it infeasible."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.body_pair import BodyPair
from planning.goals.goal_query import GoalQuery
from planning.goals.start import limit_violations, pair_evidence
from planning.world.constraints.body_pairs import moved_bodies
from planning.world.world import World

# Margins tried, as shares of the least distance, and their reserve below that distance [m].
_SHARES, _BELOW = (1.0, 0.9, 0.5, 0.0), 1e-6


def relaxation_of(
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
    faults = [_faults(world, query, q) for q in rows]
    best = min(range(len(faults)), key=lambda k: (_kinds(faults[k]), _depth(faults[k]), k))
    limits, pairs, constraints = faults[best]
    return {
        "goal_index": best,
        "positions": rows[best].tolist(),
        "limits": limits,
        "obstacles": pair_evidence(pairs, query.margins),
        "constraints": constraints,
        "remove": _in_the_way(moved_bodies(world.drake, query.group), pairs),
        "margin": _margin_that_does(world, query, rows[best], pairs),
    }


type _Faults = tuple[list[dict[str, Any]], tuple[BodyPair, ...], list[dict[str, Any]]]


def _faults(world: World, query: GoalQuery, q: Float64[np.ndarray, " nq"]) -> _Faults:
    outside = limit_violations(world.limits(query.group), query.group, q)
    pairs = world.violations(query.group, q, query.margins)
    broken = [] if query.rules is None else query.rules.violations(q)
    return outside, pairs, broken


def _kinds(faults: _Faults) -> int:
    return sum(bool(some) for some in faults)


def _depth(faults: _Faults) -> float:
    """Return the largest penetration depth of a pair [m], regardless of its margin."""
    return max((-pair.distance for pair in faults[1]), default=-np.inf)


def _in_the_way(moved: set[str], pairs: Iterable[BodyPair]) -> list[str] | None:
    """Return the bodies whose removal leaves no pair colliding; None for a self-collision.

    Of a pair with one body that the group moves, the other body is removed. Of a pair that the
    group does not move, which collides at every q, the second body is removed, unless one of them
    is already.
    """
    chosen: dict[str, None] = {}
    resting: list[tuple[str, str]] = []
    for pair in pairs:
        still = [body for body in pair.bodies if body not in moved]
        if not still:
            return None
        if len(still) == 1:
            chosen[still[0]] = None
        else:
            resting.append(pair.bodies)
    for bodies in resting:
        if not set(bodies) & set(chosen):
            chosen[bodies[1]] = None
    return sorted(chosen)


def _margin_that_does(
    world: World,
    query: GoalQuery,
    q: Float64[np.ndarray, " nq"],
    pairs: tuple[BodyPair, ...],
) -> float | None:
    """Return the largest of a few request margins at which q is free [m]; None if there is none.

    Margins of the scene for specific pairs stay as they are.
    """
    fixed = query.margins.by_pair
    if not pairs or min(pair.distance for pair in pairs) < 0:
        return None
    if any(tuple(sorted(pair.bodies)) in fixed for pair in pairs):
        return None
    least = min(pair.distance for pair in pairs) - _BELOW
    for share in _SHARES:
        margin = max(share * least, 0.0)
        if world.collision_oracle(query.group, world.margins(margin)).is_free(q):
            return margin
    return None
