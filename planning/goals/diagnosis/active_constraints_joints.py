"""Active constraints at the feasible configuration nearest to an infeasible joint goal."""

from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.goals.goal_configurations import NearestConfiguration
from planning.domain.robot.joints import JointLimits
from planning.domain.robot.manifold import Manifold
from planning.goals.diagnosis.nearest_joints import NearestJoints
from planning.goals.goal_query import GoalQuery
from planning.world.world import World

# Distance from its bound within which a pair or a joint is active [m, rad].
_AT_BOUND = 1e-4
# Steps towards the goal, as shares of the geodesic; the last one arrives.
_SHARES = np.append(10 ** np.linspace(-5.0, -0.25, 20), 1.0)


def described(
    world: World, query: GoalQuery, tight: JointLimits, goal: Array, found: NearestJoints
) -> NearestConfiguration:
    """Return the nearest feasible configuration with the constraints that are active there.

    At a minimum of the distance the straight motion to the goal is blocked at once. Active are the
    constraints that its first infeasible step violates, body pairs at their margins that come
    nearer there, and joints at a limit that differ from the goal.

    Args:
        world: Loaded scene.
        query: Goal query.
        tight: Joint limits of the group under the path constraints.
        goal: Goal configuration, shape (nq,).
        found: Nearest feasible configuration.
    """
    group, q = query.group, found.q
    manifold = Manifold(group.joints)
    stopped = _at_bound(tight, q) & (np.abs(q - goal) > _AT_BOUND)
    limited = stopped & _at_bound(world.limits(group), q)
    pairs, constraints = _barred(world, query, q, np.clip(goal, tight.lower, tight.upper))
    if query.rules is not None:
        beyond = np.where(stopped, q + _SHARES[-2] * (goal - q), q)
        constraints += tuple(entry["constraint"] for entry in query.rules.violations(beyond))
    return NearestConfiguration(
        positions=q,
        distance=found.cost,
        differences=manifold.minus(q, goal),
        names=group.velocity_names,
        goal_index=found.index,
        pairs=pairs,
        constraints=tuple(dict.fromkeys(constraints)),
        joints=tuple(np.array(group.position_names)[limited].tolist()),
    )


def _at_bound(limits: JointLimits, q: Array) -> Any:
    return np.minimum(q - limits.lower, limits.upper - q) < _AT_BOUND


def _barred(
    world: World, query: GoalQuery, q: Array, goal: Array
) -> tuple[tuple[tuple[str, str], ...], tuple[str, ...]]:
    """Return the body pairs and the path constraints that block the straight motion to the goal."""
    for step in Manifold(query.group.joints).interpolate(q, goal, _SHARES):
        violated = world.violations(query.group, step, query.margins)
        broken = [] if query.rules is None else query.rules.violations(step)
        if violated or broken:
            touching = _touching(world, query, q, step)
            pairs = dict.fromkeys([*(pair.bodies for pair in violated), *touching])
            return tuple(pairs), tuple(entry["constraint"] for entry in broken)
    return (), ()


def _touching(world: World, query: GoalQuery, q: Array, then: Array) -> list[tuple[str, str]]:
    """Return the body pairs that are at their margins at q and come nearer by a step."""
    margins = query.margins
    probe = world.distance_probe(margins)
    reach = margins.largest + 2 * _AT_BOUND
    here, there = (
        {pair.bodies: pair.distance for pair in probe.pairs_within(full, reach)}
        for full in world.embed(query.group, np.stack([q, then]))
    )
    return [
        bodies
        for bodies, distance in here.items()
        if distance < margins.of(*bodies) + _AT_BOUND and there.get(bodies, np.inf) < distance
    ]
