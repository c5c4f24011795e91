"""Suggestions for an infeasible tool goal: nearest feasible pose and sufficient relaxations."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.goals.goal_configurations import ActiveConstraints, NearestPose
from planning.domain.request.deadline import Deadline
from planning.goals.diagnosis.distance_text import degrees, millimetres
from planning.goals.diagnosis.nearest_pose import NearestPoseSearch
from planning.goals.diagnosis.relaxation import sufficient_single_relaxation, sufficient_tolerance
from planning.goals.diagnosis.relaxed_search import sufficient_constraint_relaxations
from planning.goals.goal_query import GoalQuery
from planning.goals.lines.line_stop import describe_stop
from planning.goals.targets.target_selection import TargetSelection, select_targets
from planning.world.world import World

# Share of the remaining time for goals that searches without a path constraint may take.
_RELAXED_TIME_FRACTION = 0.3
# Largest number of configurations that reach a goal used as hints.
_MAX_HINTS = 32
# Pose errors below these may come from rounded numbers in the request [m, rad].
_ROUNDED_LENGTH, _ROUNDED_ANGLE = 1e-3, 1e-3


def suggest_nearest_pose(
    world: World,
    query: GoalQuery,
    selection: TargetSelection,
    hints: Float64[np.ndarray, "n nq"],
    rng: np.random.Generator,
    deadline: Deadline,
) -> tuple[dict[str, Any], str]:
    """Return the nearest feasible pose, and relaxations each of which is sufficient.

    Args:
        world: Loaded scene, with the joint limits under the query's path constraints.
        query: Goal query.
        selection: Target selection of the goal; its accepted targets count.
        hints: Infeasible configurations that reach the goal, or nearly.
        rng: Random generator of the attempts.
        deadline: Time limit, after which the best results so far are returned.

    Returns:
        `nearest` and `relaxation` as evidence, and the nearest as text for a message.
    """
    search = NearestPoseSearch(world, query, selection.accepted, rng, deadline)
    nearest = search.run(hints)
    relaxation: dict[str, Any] = {
        "tolerance": None,
        "position": None,
        "rotation": None,
        "obstacles": [],
        "positions": None,
        "cut_short": search.is_out_of_time,
    }
    if nearest is not None:
        target = selection.accepted[nearest.pose_index]
        relaxation["tolerance"] = sufficient_tolerance(world, query, target, nearest, deadline)
        relaxation |= sufficient_single_relaxation(
            world, query, target, nearest, (rng, deadline.at_fraction(0.5))
        )
    evidence = {"nearest": nearest and nearest.evidence, "relaxation": relaxation}
    return evidence, _describe_nearest(nearest)


def suggest_reachable_without_constraint(
    world: World,
    query: GoalQuery,
    rows: Float64[np.ndarray, "n nq"],
    rng: np.random.Generator,
    deadline: Deadline,
) -> tuple[dict[str, Any], str]:
    """Return suggestions for a goal whose free configurations all violate path constraints.

    The result is that of `suggest_nearest_pose`; its relaxation also has the `constraints` each of
    which is sufficient to relax.

    Args:
        world: Loaded scene, with its own limits.
        query: Goal query with path constraints.
        rows: Free configurations that reach the goal.
        rng: Random generator of the attempts.
        deadline: Time limit, after which the best results so far are returned.
    """
    path_constraints = query.constraints
    assert path_constraints is not None  # noqa: S101  (the configurations violate them)
    constraints = sufficient_constraint_relaxations(
        world, query, rng, deadline.at_fraction(_RELAXED_TIME_FRACTION)
    )
    constrained_world = world.with_limits(
        query.group, path_constraints.limits_with_locks(world.limits(query.group))
    )
    selection = select_targets(world, query, rng)
    evidence, text = suggest_nearest_pose(
        constrained_world, query, selection, rows[:_MAX_HINTS], rng, deadline
    )
    evidence["relaxation"]["constraints"] = constraints
    if constraints:
        text += f"; relaxing {' or '.join(map(_describe_relaxation, constraints))} is sufficient"
    return evidence, text


def _describe_relaxation(entry: dict[str, Any]) -> str:
    if entry["value"] is None or entry["unit"] == "1":
        return str(entry["constraint"])
    return f"{entry['constraint']} (to {entry['value']:.4g} {entry['unit']})"


def _describe_nearest(nearest: NearestPose | None) -> str:
    if nearest is None:
        return ""
    distance_text = (
        f"{millimetres(nearest.translation_error)} and {degrees(nearest.rotation_error)} away"
    )
    if nearest.active_constraints is None:
        return f"; the nearest free pose that was found in time is {distance_text}"
    reasons = _describe_active_constraints(nearest.active_constraints)
    text = f"; the nearest free pose is {distance_text}, {reasons}"
    is_rounding = (
        nearest.translation_error < _ROUNDED_LENGTH and nearest.rotation_error < _ROUNDED_ANGLE
    )
    if is_rounding and nearest.active_constraints.binding == "reach":
        text += (
            "; such a small error may come from rounded numbers (3.14159 for pi): "
            "give a `tolerance`"
        )
    return text


def _describe_active_constraints(active: ActiveConstraints) -> str:
    if active.linear_move_stop is not None:
        move_stop = active.linear_move_stop
        return f"blocked by the {move_stop.move}: {describe_stop(move_stop.stop)}"
    return {
        "collision": f"blocked by {', '.join('-'.join(pair) for pair in active.pairs)}",
        "path_constraint": f"blocked by {', '.join(active.constraints)}",
        "limits": f"blocked by the limits of {', '.join(active.joints)}",
        "reach": "limited by the reach of the arm",
    }[active.binding]
