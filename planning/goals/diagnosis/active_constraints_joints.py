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
_ACTIVE_TOLERANCE = 1e-4
# Steps towards the goal, as shares of the geodesic; the last one ends at the goal.
_STEP_FRACTIONS = np.append(10 ** np.linspace(-5.0, -0.25, 20), 1.0)


def with_active_constraints(
    world: World,
    query: GoalQuery,
    constrained_limits: JointLimits,
    goal: Array,
    nearest: NearestJoints,
) -> NearestConfiguration:
    """Return the nearest feasible configuration with the constraints that are active there.

    At a minimum of the distance the straight motion to the goal is blocked at once. Active are the
    constraints that its first infeasible step violates, body pairs at their margins that come
    nearer there, and joints at a limit that differ from the goal.

    Args:
        world: Loaded scene.
        query: Goal query.
        constrained_limits: Joint limits of the group under the path constraints.
        goal: Goal configuration, shape (nq,).
        nearest: Nearest feasible configuration.
    """
    group, q = query.group, nearest.q
    manifold = Manifold(group.joints)
    is_active = _at_bound(constrained_limits, q) & (np.abs(q - goal) > _ACTIVE_TOLERANCE)
    is_at_limit = is_active & _at_bound(world.limits(group), q)
    pairs, constraints = _blocking_constraints(
        world, query, q, np.clip(goal, constrained_limits.lower, constrained_limits.upper)
    )
    if query.constraints is not None:
        beyond = np.where(is_active, q + _STEP_FRACTIONS[-2] * (goal - q), q)
        constraints += tuple(entry["constraint"] for entry in query.constraints.violations(beyond))
    return NearestConfiguration(
        positions=q,
        distance=nearest.cost,
        differences=manifold.minus(q, goal),
        names=group.velocity_names,
        goal_index=nearest.index,
        pairs=pairs,
        constraints=tuple(dict.fromkeys(constraints)),
        joints=tuple(np.array(group.position_names)[is_at_limit].tolist()),
    )


def _at_bound(limits: JointLimits, q: Array) -> Any:
    return np.minimum(q - limits.lower, limits.upper - q) < _ACTIVE_TOLERANCE


def _blocking_constraints(
    world: World, query: GoalQuery, q: Array, goal: Array
) -> tuple[tuple[tuple[str, str], ...], tuple[str, ...]]:
    """Return the body pairs and the path constraints that block the straight motion to the goal."""
    for step in Manifold(query.group.joints).interpolate(q, goal, _STEP_FRACTIONS):
        violating_pairs = world.violations(query.group, step, query.margins)
        violated_constraints = (
            [] if query.constraints is None else query.constraints.violations(step)
        )
        if violating_pairs or violated_constraints:
            active_pairs = _active_pairs(world, query, q, step)
            pairs = dict.fromkeys([*(pair.bodies for pair in violating_pairs), *active_pairs])
            return tuple(pairs), tuple(entry["constraint"] for entry in violated_constraints)
    return (), ()


def _active_pairs(world: World, query: GoalQuery, q: Array, next_q: Array) -> list[tuple[str, str]]:
    """Return the body pairs that are at their margins at q and come nearer by a step."""
    margins = query.margins
    probe = world.distance_probe(margins)
    search_radius = margins.largest + 2 * _ACTIVE_TOLERANCE
    distances, next_distances = (
        {pair.bodies: pair.distance for pair in probe.pairs_within(full, search_radius)}
        for full in world.embed(query.group, np.stack([q, next_q]))
    )
    return [
        bodies
        for bodies, distance in distances.items()
        if distance < margins.of(*bodies) + _ACTIVE_TOLERANCE
        and next_distances.get(bodies, np.inf) < distance
    ]
