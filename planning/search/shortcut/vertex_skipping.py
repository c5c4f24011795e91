"""The furthest that can be seen: waypoints that can be left out of a path.

From one waypoint on, the last one of all that can be reached by a free edge comes next. Far ends
are tried first: an edge that is blocked is found out soon, one that is free is looked at from end
to end, and of those only few are needed that way.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.search.edges import EdgeChecker
from planning.search.shortcut.polyline import Points, points_on

type Array = np.ndarray[Any, np.dtype[np.float64]]

_PIECES = 4


def skip_vertices(
    waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker, is_over: Callable[[], bool]
) -> Array | None:
    """Return some of the waypoints, both ends among them, joined by edges that are checked.

    Of the given path nothing is taken for granted. If no way leads on from a waypoint another way
    is taken to those after it; None if no edges between waypoints lead from end to end.

    Args:
        waypoints: From start to goal, shape (n, nq).
        edges: Checks them all.
        is_over: Whether there is no time for more than the given path's own edges.
    """
    last = len(waypoints) - 1
    chain, untried = [0], [last]
    is_dead = np.zeros(last + 1, dtype=bool)
    while chain and chain[-1] < last:
        here, there = chain[-1], untried[-1]
        if is_over():
            there = min(there, here + 1)
        while there > here and (
            is_dead[there] or not edges.is_free(waypoints[here], waypoints[there])
        ):
            there -= 1
        untried[-1] = there - 1
        if there > here:
            chain.append(there)
            untried.append(last)
        else:
            is_dead[here] = True
            chain.pop()
            untried.pop()
    return waypoints[chain] if chain else None


def tighten(waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker) -> Array:
    """Return a path of free edges that is no longer, from one of free edges; goal to start.

    It leaves the given path at points on its edges too, as a rope does that is pulled around a
    corner from the goal's side: `skip_vertices` comes from the start's.
    """
    points = points_on(waypoints, edges, _PIECES).backwards
    chain = [0]
    while chain[-1] < len(points.qs) - 1:
        chain.append(_furthest(points, chain[-1], edges))
    return np.ascontiguousarray(points.qs[chain][::-1])


def _furthest(points: Points, here: int, edges: EdgeChecker) -> int:
    there = len(points.qs) - 1
    while not points.share_edge(here, there) and not edges.is_free(
        points.qs[there], points.qs[here]
    ):
        there -= 1
    return there
