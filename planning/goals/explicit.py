"""Explicit goal configurations (joint goals): given by joint positions or by name, checked."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.body_pair import BodyPair
from planning.domain.goals.funnel import Funnel, funnel_evidence
from planning.domain.goals.goal import ConfigurationGoal, JointGoal
from planning.domain.goals.goal_configurations import GoalConfigurations, NearestConfiguration
from planning.domain.request.deadline import Deadline
from planning.domain.robot.manifold import Manifold
from planning.errors import GoalInCollision, GoalOutOfLimits, GoalTooNear
from planning.goals.diagnosis.active_constraints_joints import with_active_constraints
from planning.goals.diagnosis.collision_tally import CollisionTally
from planning.goals.diagnosis.joint_relaxation import joint_goal_relaxation
from planning.goals.diagnosis.nearest_joints import NearestJointSearch
from planning.goals.goal_query import GoalQuery
from planning.goals.joint_metric import JointMetric
from planning.goals.ranking import nearest_first
from planning.goals.start_validation import (
    clip_rounding,
    describe_pairs,
    has_overlap,
    limit_violations,
    pair_evidence,
    within_limits,
)
from planning.world.loading.positions import validate_positions
from planning.world.world import World

type ExplicitGoal = JointGoal | ConfigurationGoal

# Largest number of given configurations in the search for suggestions.
_MAX_CONFIGURATIONS = 64
# Share of the remaining time for goals that the search for the nearest configuration may take.
_NEAREST_TIME_FRACTION = 0.5


def explicit_goal_configurations(
    world: World,
    query: GoalQuery,
    goal: ExplicitGoal,
    rng: np.random.Generator,
    deadline: Deadline,
) -> GoalConfigurations:
    """Return the given configurations that are within limits and free, nearest to the start first.

    Raises:
        GoalOutOfLimits: Every configuration violates position limits.
        GoalInCollision: Bodies overlap in every configuration within limits.
        GoalTooNear: None is free, and at least one violates only margins.
        ProblemInvalid: A configuration has the wrong number of positions.
        UnknownName: There is no configuration of that name.
    """
    group, limits = query.group, world.limits(query.group)
    rows = clip_rounding(
        limits, Manifold.of(group.joints), unchecked_configurations(world, query, goal)
    )
    inside = np.flatnonzero(within_limits(limits, rows))
    if not len(inside):
        outside = limit_violations(limits, group, rows[0])
        worst = max(outside, key=lambda entry: entry["violation"])
        evidence, suggestion = suggest_nearest_joints(world, query, goal, rng, deadline)
        message = (
            f"no goal configuration is within limits: {worst['joint']} = {worst['position']:.6g} "
            f"is not in [{worst['lower']:.6g}, {worst['upper']:.6g}]{suggestion}"
        )
        raise GoalOutOfLimits(message, {"joints": outside, **evidence})
    is_free = world.collision_oracle(group, query.margins).are_free(rows[inside])
    tally = CollisionTally()
    pairs = tuple[BodyPair, ...]()
    for k in np.flatnonzero(~is_free):
        violations = world.violations(group, rows[inside[k]], query.margins)
        is_free[k] = not violations
        if not pairs or (has_overlap(pairs) and not has_overlap(violations)):
            pairs = violations  # of a configuration that only violates margins, if there is one
        tally.add(violations, query.margins)
    free = inside[is_free]
    counts = len(rows), len(rows), len(inside), len(free), len(free)
    funnel = Funnel(*counts, tally.summary, num_with_linear_moves=len(free))
    if not len(free):
        evidence, suggestion = suggest_nearest_joints(world, query, goal, rng, deadline)
        evidence |= {
            "funnel": funnel_evidence(funnel),
            "pairs": pair_evidence(pairs, query.margins),
        }
        pair_text = describe_pairs(pairs, query.margins) + suggestion
        if tally.num_margin_only:
            message = (
                "every goal configuration violates margins, and at least one does not collide: "
                f"{pair_text}"
            )
            raise GoalTooNear(message, evidence)
        raise GoalInCollision(f"every goal configuration collides: {pair_text}", evidence)
    metric = JointMetric.from_names(group, query.options.joint_weights)
    positions, indices = nearest_first(metric, query.start, rows[free], free, len(free))
    return GoalConfigurations(positions, indices, funnel)


def unchecked_configurations(
    world: World, query: GoalQuery, goal: ExplicitGoal
) -> Float64[np.ndarray, "n nq"]:
    """Return the configurations of a goal, unchecked against limits.

    Raises:
        ProblemInvalid: A configuration has the wrong number of positions.
        UnknownName: There is no configuration of that name.
    """
    if isinstance(goal, ConfigurationGoal):
        return world.configuration(query.group, goal.name)[None]
    return np.stack([
        validate_positions(query.group, q, f"goal.positions.{i}")
        for i, q in enumerate(goal.positions)
    ])


def suggest_nearest_joints(
    world: World,
    query: GoalQuery,
    goal: ExplicitGoal,
    rng: np.random.Generator,
    deadline: Deadline,
) -> tuple[dict[str, Any], str]:
    """Return the feasible configuration nearest to infeasible given ones, and relaxations.

    Returns:
        `nearest` and `relaxation` as evidence, and the nearest as text for a message.
    """
    group = query.group
    rows = clip_rounding(
        world.limits(group),
        Manifold.of(group.joints),
        unchecked_configurations(world, query, goal)[:_MAX_CONFIGURATIONS],
    )
    constraints = query.constraints
    constrained_world = (
        world
        if constraints is None
        else world.with_limits(group, constraints.limits_with_locks(world.limits(group)))
    )
    search_deadline = deadline.at_fraction(_NEAREST_TIME_FRACTION)
    result = NearestJointSearch(constrained_world, query, rows, rng, search_deadline).run()
    is_cut_short = search_deadline.is_over
    nearest = result and with_active_constraints(
        world, query, constrained_world.limits(group), rows[result.index], result
    )
    evidence = {
        "nearest": nearest and {**nearest.evidence, "cut_short": is_cut_short},
        "relaxation": joint_goal_relaxation(world, query, rows),
    }
    if nearest is None:
        return evidence, ""
    return evidence, _describe_nearest(nearest, is_cut_short=is_cut_short)


def _describe_nearest(nearest: NearestConfiguration, *, is_cut_short: bool) -> str:
    active_names = [*("-".join(pair) for pair in nearest.pairs), *nearest.constraints]
    active_names += [f"the limit of {name}" for name in nearest.joints]
    largest = int(np.argmax(np.abs(nearest.differences)))
    which = "configuration that was found in time" if is_cut_short else "configuration"
    return (
        f"; the nearest feasible {which} is {nearest.distance:.4g} away "
        f"({nearest.names[largest]} by {nearest.differences[largest]:.4g})"
        + (f", blocked by {', '.join(active_names)}" if active_names else "")
    )
