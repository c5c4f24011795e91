"""Sufficient relaxations of a tool goal: larger tolerances, or body pairs allowed to collide."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.body_pair import BodyPair
from planning.domain.goals.goal_configurations import NearestPose
from planning.domain.request.deadline import Deadline
from planning.goals.diagnosis.nearest_program import Target
from planning.goals.diagnosis.partial_pose import Freedom, PartialPoseSearch
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_attempts import PoseAttempts
from planning.goals.lines.approach_feasibility import approach_feasibility
from planning.world.world import World


def sufficient_tolerance(
    world: World, query: GoalQuery, target: Target, nearest: NearestPose, deadline: Deadline
) -> dict[str, Any] | None:
    """Return tolerances [m, rad] with which the nearest feasible pose is a solution, as evidence.

    None if the pose's approach and retreat are free only with the goal's axes turned along with it.
    """
    approach_check = approach_feasibility(world, query, [target], deadline)
    if (
        approach_check is not None
        and not approach_check.are_free_in_place(nearest.positions[None], 0)[0]
    ):
        return None
    position, turn = target.widened_tolerances(nearest.pose)
    return {
        "pose_index": nearest.pose_index,
        "position": position.tolist(),
        "rotation": turn.tolist(),
    }


def sufficient_single_relaxation(
    world: World,
    query: GoalQuery,
    target: Target,
    nearest: NearestPose,
    search: tuple[np.random.Generator, Deadline],
) -> dict[str, Any]:
    """Return two relaxations, each sufficient alone: of the position and of the rotation.

    Each error is at least the distance of the nearest pose in the pose metric, since nothing nearer
    is free. Goals with approach or retreat get no rotation, since their axes stay in place. If time
    ran out, which `cut_short` says, smaller errors may be sufficient.

    Args:
        world: Loaded scene.
        query: Goal query.
        target: Target pose of the goal.
        nearest: Feasible pose nearest to the target.
        search: Random generator of the attempts, and time limit of the search.
    """
    rng, deadline = search
    metric = query.options.pose_metric
    cost = float(
        np.hypot(
            metric.translation * nearest.translation_error, metric.rotation * nearest.rotation_error
        )
    )
    goal = target.closest(nearest.pose)
    attempts = PoseAttempts(world, query, [target], rng, deadline)
    attempts.hints = nearest.positions[None]
    evidence: dict[str, Any] = {"cut_short": nearest.active_constraints is None}
    for freedom, weight in (
        (Freedom.POSITION, metric.translation),
        (Freedom.ROTATION, metric.rotation),
    ):
        if freedom is Freedom.ROTATION and attempts.approach_check is not None:
            evidence["rotation"] = None
            continue
        part_deadline = deadline.at_fraction(0.5)
        result = PartialPoseSearch(attempts, goal, freedom).run(cost / weight, rng, part_deadline)
        evidence["cut_short"] |= part_deadline.is_over
        evidence[freedom.name.lower()] = result and {
            "error": result.error,
            "pose_index": nearest.pose_index,
            "positions": result.q.tolist(),
        }
    return evidence


def shallowest_collision(
    world: World, query: GoalQuery, rows: Float64[np.ndarray, "n nq"]
) -> tuple[Float64[np.ndarray, " nq"], tuple[BodyPair, ...]]:
    """Return the row with the smallest maximum margin violation, with its violating pairs.

    With these pairs allowed to collide, or apart by their depth, the row would be a solution.
    """
    margins = query.margins
    violations = [world.violations(query.group, q, margins) for q in rows]
    depths = [
        max((margins.of(*p.bodies) - p.distance for p in pairs), default=0) for pairs in violations
    ]
    best = int(np.argmin(depths))
    return rows[best], violations[best]
