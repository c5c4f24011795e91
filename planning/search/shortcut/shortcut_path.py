"""Shortcutting: a shorter polyline of geodesics between the same ends, every edge checked.

OMPL's simplifier may leave the valid set and stops by the clock. Here

    skip      from the start: the furthest waypoint that a free edge reaches comes next,
    tighten   from the goal: the same with points on the edges, like a rope pulled around corners,
    relax     waypoints move toward the chords of their neighbours,
    cut       corners that still cost much become two waypoints,

and the last two are repeated. The result is deterministic. Relaxation checks at the planner's
resolution only, since most of its moves are superseded; then it is undone where a check at the fine
resolution finds a collision. All the rest is checked at the fine resolution at once, and
pieces of a checked edge are not checked again: so the path is free at the fine resolution after
every stage.
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.errors import DeadlineExceeded
from planning.search.edges import EdgeChecker
from planning.search.shortcut.backtracking import backtrack
from planning.search.shortcut.corners import cut_corners
from planning.search.shortcut.relax import relax
from planning.search.shortcut.vertex_skipping import skip_vertices, tighten

# Number of rounds of relaxation and corner cutting.
_NUM_ROUNDS = 3


def shortcut(
    waypoints: Float64[np.ndarray, "n nq"],
    coarse: EdgeChecker,
    fine: EdgeChecker,
    is_over: Callable[[], bool],
) -> Array | None:
    """Return a path that is no longer, with the same ends, shape (m, nq), free by `fine`.

    None if the given path is blocked at `fine` and no free edges join its waypoints.

    Args:
        waypoints: From start to goal, shape (n, nq).
        coarse: Checker of intermediate moves.
        fine: Checker of the result.
        is_over: Called at intervals; after an early end the path is as valid as otherwise.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out before any free path was found.
    """
    path = skip_vertices(waypoints, fine, is_over)
    if path is None:
        return None
    stages = [tighten, *[_relaxation_stage(coarse, is_over), cut_corners] * _NUM_ROUNDS]
    stages.append(_relaxation_stage(coarse, is_over))
    try:
        for stage in stages:
            if len(path) < 3 or is_over():
                break
            shorter = stage(path, fine)
            if shorter is None:
                break
            path = shorter
    except DeadlineExceeded:
        # The path is free after every stage; more time would only have made it shorter.
        return path
    return path


def _relaxation_stage(
    coarse: EdgeChecker, is_over: Callable[[], bool]
) -> Callable[[Array, EdgeChecker], Array | None]:
    def relax_and_backtrack(path: Array, fine: EdgeChecker) -> Array | None:
        return backtrack(relax(path, coarse, is_over), path, fine)

    return relax_and_backtrack
