"""What there is to say of a goal of a tool frame that has no solution: the nearest one that has."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.deadline import Deadline
from planning.domain.goal_configurations import Bounds, NearestPose
from planning.goals.aims import Aiming
from planning.goals.goal_query import GoalQuery
from planning.goals.line_stop import describe_stop
from planning.goals.nearest import NearestSearch
from planning.goals.relaxation import alone_that_does, tolerance_that_does
from planning.world.world import World

# Of what remains of the time for goals, what the search for the nearest pose may take.
_NEAREST_SHARE = 0.7


def nearest_that_does(
    world: World,
    query: GoalQuery,
    aiming: Aiming,
    hints: Float64[np.ndarray, "n nq"],
    rng: np.random.Generator,
    deadline: Deadline,
) -> tuple[dict[str, Any], str]:
    """Return the nearest feasible pose, and the tolerances of which each would do.

    Args:
        world: The scene, with the limits that the query's rules leave.
        query: The goal.
        aiming: What counts as reached.
        hints: Configurations that reach the goal, or nearly, but will not do.
        rng: Of the tries.
        deadline: When to stop with what there is.

    Returns:
        `nearest` and `relaxation` as evidence, and the nearest as words for a message.
    """
    search = NearestSearch(world, query, aiming.accepted, rng, deadline.share(_NEAREST_SHARE))
    found = search.run(hints)
    relaxation: dict[str, Any] = {
        "tolerance": None,
        "position": None,
        "rotation": None,
        "obstacles": [],
        "positions": None,
    }
    if found is not None:
        target = aiming.accepted[found.pose_index]
        relaxation["tolerance"] = tolerance_that_does(world, query, target, found, deadline)
        relaxation |= alone_that_does(world, query, target, found, (rng, deadline.share(0.5)))
    return {"nearest": found and found.evidence, "relaxation": relaxation}, _describe(found)


def _describe(found: NearestPose | None) -> str:
    if found is None:
        return ""
    return (
        f"; the nearest free pose is {1000 * found.translation_error:.1f} mm and "
        f"{np.degrees(found.rotation_error):.2f} deg away, where {_binding(found.bounds)}"
    )


def _binding(bounds: Bounds) -> str:
    if bounds.line is not None:
        return f"the {bounds.line.leg} binds: {describe_stop(bounds.line.stop)}"
    return {
        "collision": f"{', '.join('-'.join(pair) for pair in bounds.pairs)} bind",
        "path_constraint": f"{', '.join(bounds.constraints)} bind",
        "limits": f"{', '.join(bounds.joints)} at their limits bind",
        "reach": "the reach binds",
    }[bounds.binding]
