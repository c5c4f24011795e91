"""What of a goal, or of its surroundings, would have to give way for it to have a solution."""

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
    """Return a tolerance with which the nearest feasible pose is a solution, as evidence.

    None if it has the goal's lines only where the goal's axes turn with it.
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
    """Return tolerances of which each would do, of the position and of the rotation alone.

    They are at least the errors of the nearest pose in the pose metric: nothing nearer is free. A
    turn is no way out for goals with lines, whose axes stay where they are. Less may do where time
    ran out, which `cut_short` says.

    Args:
        world: The scene.
        query: The goal.
        target: Which of its poses.
        nearest: The nearest feasible pose to that.
        search: Of the tries, and when to stop with what there is.
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
    """Return the row whose deepest collision is the least deep, with its colliding pairs.

    If these pairs were allowed to touch, or stood back by their depth, it would be a solution.
    """
    margins = query.margins
    hits = [world.violations(query.group, q, margins) for q in rows]
    depths = [max((margins.of(*p.bodies) - p.distance for p in pairs), default=0) for pairs in hits]
    best = int(np.argmin(depths))
    return rows[best], hits[best]
