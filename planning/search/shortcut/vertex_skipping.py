"""Vertex skipping: waypoints left out of a path by the furthest free edges.

After one waypoint comes the last one that a free edge reaches. Far ends are tried first: a blocked
edge is detected early, a free one is checked from end to end, and this order needs only few free
ones.
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.search.edges import EdgeChecker
from planning.search.shortcut.polyline import PolylinePoints, subdivide

_PARTS_PER_EDGE = 4


def skip_vertices(
    waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker, is_over: Callable[[], bool]
) -> Array | None:
    """Return some of the waypoints, both ends among them, joined by edges that are checked.

    No edge of the given path is assumed to be free. If no edge leads on from a waypoint, another
    chain to those after it is tried; None if no edges between waypoints lead from end to end.

    Args:
        waypoints: From start to goal, shape (n, nq).
        edges: Checker of all edges.
        is_over: Whether there is time only for the given path's own edges.
    """
    if not edges.uses_kernel:
        return skip_vertices_in_numpy(waypoints, edges, is_over)
    path = edges.in_kernel("skip_vertices", waypoints, is_over)
    return path if len(path) else None


def skip_vertices_in_numpy(
    waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker, is_over: Callable[[], bool]
) -> Array | None:
    """Return the same for any joints; what the kernel is compared with."""
    last = len(waypoints) - 1
    chain, untried = [0], [last]
    is_dead = np.zeros(last + 1, dtype=bool)
    while chain and chain[-1] < last:
        here, there = chain[-1], untried[-1]
        if is_over():
            there = min(there, here + 1)
        others = np.arange(there, here, -1)
        others = others[~is_dead[others]]
        first = edges.first_free(waypoints[here : here + 1], waypoints[others])
        there = int(others[first]) if first < len(others) else here
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
    """Return a path of free edges that is no longer, from one of free edges; from goal to start.

    It may leave the given path at points on its edges too, like a rope pulled around a corner from
    the goal's side; `skip_vertices` starts at the other end.
    """
    if edges.uses_kernel:
        return edges.in_kernel("tighten", waypoints, _PARTS_PER_EDGE)
    return tighten_in_numpy(waypoints, edges)


def tighten_in_numpy(waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker) -> Array:
    """Return the same for any joints; what the kernel is compared with."""
    points = subdivide(waypoints, edges, _PARTS_PER_EDGE).in_reverse
    chain = [0]
    while chain[-1] < len(points.qs) - 1:
        chain.append(_furthest(points, chain[-1], edges))
    return np.ascontiguousarray(points.qs[chain][::-1])


def _furthest(points: PolylinePoints, here: int, edges: EdgeChecker) -> int:
    """Return the last point that a free edge joins to one, at least the last one on its edge."""
    last = len(points.qs) - 1
    nearest = points.last_on_edge_of(here)
    others = np.ascontiguousarray(points.qs[last:nearest:-1])
    return last - edges.first_free(others, points.qs[here : here + 1])
