"""What of a goal, or of its surroundings, would have to give way for it to have a solution."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.report import BodyPair, NearestPose
from planning.goals.goal_query import GoalQuery
from planning.goals.nearest_program import Target
from planning.world.world import World


def tolerance_that_does(target: Target, nearest: NearestPose) -> dict[str, Any]:
    """Return a tolerance with which the nearest feasible pose is a solution, as evidence."""
    position, turn = target.widened(nearest.pose)
    return {
        "pose_index": nearest.pose_index,
        "position": position.tolist(),
        "rotation": turn.tolist(),
    }


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
