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
    lines = approach_feasibility(world, query, [target], deadline)
    if lines is not None and not lines.are_free_from(nearest.positions[None], 0)[0]:
        return None
    position, turn = target.widened(nearest.pose)
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
    ran out, which `cut_short` tells, smaller errors may be sufficient.

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
    tries = PoseAttempts(world, query, [target], rng, deadline)
    tries.hints = nearest.positions[None]
    found: dict[str, Any] = {"cut_short": nearest.bounds is None}
    for freedom, weight in (
        (Freedom.POSITION, metric.translation),
        (Freedom.ROTATION, metric.rotation),
    ):
        if freedom is Freedom.ROTATION and tries.lines is not None:
            found["rotation"] = None
            continue
        brief = deadline.share(0.5)
        alone = PartialPoseSearch(tries, goal, freedom).run(cost / weight, rng, brief)
        found["cut_short"] |= brief.is_over
        found[freedom.name.lower()] = alone and {
            "error": alone.error,
            "pose_index": nearest.pose_index,
            "positions": alone.q.tolist(),
        }
    return found


def least_deep(
    world: World, query: GoalQuery, rows: Float64[np.ndarray, "n nq"]
) -> tuple[Float64[np.ndarray, " nq"], tuple[BodyPair, ...]]:
    """Return the row with the smallest maximum margin violation, with its violating pairs.

    With these pairs allowed to collide, or apart by their depth, the row would be a solution.
    """
    margins = query.margins
    hits = [world.violations(query.group, q, margins) for q in rows]
    depths = [max((margins.of(*p.bodies) - p.distance for p in pairs), default=0) for pairs in hits]
    best = int(np.argmin(depths))
    return rows[best], hits[best]
