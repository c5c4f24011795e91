"""Suggestions for an infeasible tool goal: nearest feasible pose and sufficient relaxations."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.goals.goal_configurations import Bounds, NearestPose
from planning.domain.request.deadline import Deadline
from planning.goals.diagnosis.distance_text import degrees, millimetres
from planning.goals.diagnosis.nearest_pose import NearestSearch
from planning.goals.diagnosis.relaxation import sufficient_single_relaxation, sufficient_tolerance
from planning.goals.diagnosis.relaxed_search import sufficient_constraint_relaxations
from planning.goals.goal_query import GoalQuery
from planning.goals.lines.line_stop import describe_stop
from planning.goals.targets.target_selection import TargetSelection, select_targets
from planning.world.world import World

# Share of the remaining time for goals that searches without a path constraint may take.
_RELAXED_SHARE = 0.3
# Largest number of configurations that reach a goal used as hints.
_MOST_HINTS = 32
# Pose errors below these may come from rounded numbers in the request [m, rad].
_ROUNDED_LENGTH, _ROUNDED_ANGLE = 1e-3, 1e-3


def suggest_nearest_pose(
    world: World,
    query: GoalQuery,
    aiming: TargetSelection,
    hints: Float64[np.ndarray, "n nq"],
    rng: np.random.Generator,
    deadline: Deadline,
) -> tuple[dict[str, Any], str]:
    """Return the nearest feasible pose, and tolerances each of which is sufficient.

    Args:
        world: Loaded scene, with the joint limits under the query's path constraints.
        query: Goal query.
        aiming: Target selection of the goal; its accepted targets count.
        hints: Infeasible configurations that reach the goal, or nearly.
        rng: Random generator of the attempts.
        deadline: Time limit, after which the best results so far are returned.

    Returns:
        `nearest` and `relaxation` as evidence, and the nearest as text for a message.
    """
    search = NearestSearch(world, query, aiming.accepted, rng, deadline)
    found = search.run(hints)
    relaxation: dict[str, Any] = {
        "tolerance": None,
        "position": None,
        "rotation": None,
        "obstacles": [],
        "positions": None,
        "cut_short": search.is_late,
    }
    if found is not None:
        target = aiming.accepted[found.pose_index]
        relaxation["tolerance"] = sufficient_tolerance(world, query, target, found, deadline)
        relaxation |= sufficient_single_relaxation(
            world, query, target, found, (rng, deadline.share(0.5))
        )
    return {"nearest": found and found.evidence, "relaxation": relaxation}, _describe(found)


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
    rules = query.rules
    assert rules is not None  # noqa: S101  (something was broken)
    constraints = sufficient_constraint_relaxations(
        world, query, rng, deadline.share(_RELAXED_SHARE)
    )
    tight = world.limited(query.group, rules.fixing(world.limits(query.group)))
    aiming = select_targets(world, query, rng)
    evidence, words = suggest_nearest_pose(tight, query, aiming, rows[:_MOST_HINTS], rng, deadline)
    evidence["relaxation"]["constraints"] = constraints
    if constraints:
        words += f"; it would do if {' or '.join(map(_gives_way, constraints))} gave way"
    return evidence, words


def _gives_way(entry: dict[str, Any]) -> str:
    if entry["value"] is None or entry["unit"] == "1":
        return str(entry["constraint"])
    return f"{entry['constraint']} (to {entry['value']:.4g} {entry['unit']})"


def _describe(found: NearestPose | None) -> str:
    if found is None:
        return ""
    away = f"{millimetres(found.translation_error)} and {degrees(found.rotation_error)} away"
    if found.bounds is None:
        return f"; the nearest free pose that was found in time is {away}"
    words = f"; the nearest free pose is {away}, where {_binding(found.bounds)}"
    is_little = found.translation_error < _ROUNDED_LENGTH and found.rotation_error < _ROUNDED_ANGLE
    if is_little and found.bounds.binding == "reach":
        words += ": so little comes of rounded numbers (3.14159 for pi), give a `tolerance`"
    return words


def _binding(bounds: Bounds) -> str:
    if bounds.line is not None:
        return f"the {bounds.line.leg} binds: {describe_stop(bounds.line.stop)}"
    return {
        "collision": f"{', '.join('-'.join(pair) for pair in bounds.pairs)} bind",
        "path_constraint": f"{', '.join(bounds.constraints)} {_bind(bounds.constraints)}",
        "limits": f"{', '.join(bounds.joints)} at their limits bind",
        "reach": "the reach binds",
    }[bounds.binding]


def _bind(names: tuple[str, ...]) -> str:
    return "bind" if len(names) > 1 else "binds"
