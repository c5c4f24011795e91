"""Shortcuts: a shorter polyline of geodesics between the same ends, every edge checked.

OMPL's simplifier may leave the valid set and stops by the clock. Here

    skip      from the start: the furthest waypoint in sight comes next,
    pull      from the goal: the same with points on the edges, as a rope is pulled around corners,
    relax     waypoints give way toward the chords of their neighbours,
    cut       corners that still cost much become two,

and the last two are done again. Nothing is random. Relaxing looks no closer than the planner does,
since most of what it tries is superseded; then it steps back where a closer look says so. All the
rest is checked at the fine resolution at once, and what is left of a checked edge is not checked
again: so the path that is delivered is free at the fine resolution, and was all along.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.errors import DeadlineExceeded
from planning.search.edges import EdgeChecker
from planning.search.shortcut.backtracking import backtrack
from planning.search.shortcut.corners import cut_corners
from planning.search.shortcut.relax import relaxed
from planning.search.shortcut.vertex_skipping import skip_vertices, tighten

type Array = np.ndarray[Any, np.dtype[np.float64]]

# How often corners are cut.
_MOST_CUTS = 3


def shortcut(
    waypoints: Float64[np.ndarray, "n nq"],
    coarse: EdgeChecker,
    fine: EdgeChecker,
    is_over: Callable[[], bool],
) -> Array | None:
    """Return a path that is no longer, with the same ends, shape (m, nq), free by `fine`.

    None if `fine` blocks the given path and finds no way between its waypoints.

    Args:
        waypoints: From start to goal, shape (n, nq).
        coarse: Checks what is tried.
        fine: Checks what is delivered.
        is_over: Asked now and then; an early end leaves a path that is as good as the others.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out before anything was found free.
    """
    path = skip_vertices(waypoints, fine, is_over)
    if path is None:
        return None
    stages = [tighten, *[_relaxed_by(coarse, is_over), cut_corners] * _MOST_CUTS]
    stages.append(_relaxed_by(coarse, is_over))
    try:
        for stage in stages:
            if len(path) < 3 or is_over():
                break
            shorter = stage(path, fine)
            if shorter is None:
                break
            path = shorter
    except DeadlineExceeded:
        # What there is by now is free; the rest of the time would have made it shorter.
        return path
    return path


def _relaxed_by(
    coarse: EdgeChecker, is_over: Callable[[], bool]
) -> Callable[[Array, EdgeChecker], Array | None]:
    def relax(path: Array, fine: EdgeChecker) -> Array | None:
        return backtrack(relaxed(path, coarse, is_over), path, fine)

    return relax
