"""Shortcuts of a car's path: parts of it replaced by free Dubins or Reeds-Shepp curves.

A car cannot follow a straight line between two of its configurations. So the path is cut into
points, and the shortest free path along some of them in order is computed, where each step is a
steering path from one point to a later one. It is LazySP: the shortest path under the assumption
that all steps whose coarse samples are free are free; then again without the steps that prove to be
blocked (Dellin and Srinivasa, "A unifying formalism for shortest path problems with expensive edge
evaluations via lazy best-first search", ICAPS 2016). The result is deterministic, and every step of
it was checked.
"""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.errors import DeadlineExceeded
from planning.search.cars.steering_edges import SteeringEdgeChecker
from planning.search.shortcut.polyline import length_by_norm, subdivide

# Approximate number of points of a path; most pieces that an edge is cut into.
_NUM_POINTS, _MAX_PARTS = 48, 8
_MAX_POINTS = 64
_MAX_ROUNDS = 4
# Least gain of a round, as a share of the length, for another round to follow.
_MIN_GAIN = 1e-3
# Cost of a step beyond its length, so that of equal paths the one of fewest steps is chosen.
_STEP_COST = 1e-6


def shortcut_steering_path(
    waypoints: Float64[np.ndarray, "n nq"], edges: SteeringEdgeChecker, is_over: Callable[[], bool]
) -> Array | None:
    """Return a path that is no longer, with the same ends, shape (m, nq), every step free.

    None if the given one is blocked and its waypoints lead to no other.

    Args:
        waypoints: Waypoints from start to goal, shape (n, nq).
        edges: Checker of steering paths at the fine resolution.
        is_over: Called at intervals; after an early end the path is as valid as otherwise.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out before any free path was found.
    """
    path = _shortest_free_path(waypoints, edges, is_over)
    try:
        for _ in range(_MAX_ROUNDS):
            if path is None or is_over():
                break
            max_parts = max(1, min(_MAX_PARTS, _NUM_POINTS // len(path)))
            shorter = _shortest_free_path(subdivide(path, edges, max_parts).qs, edges, is_over)
            if shorter is None:
                break
            gain = 1 - length_by_norm(shorter, edges) / max(length_by_norm(path, edges), 1e-12)
            path = shorter if gain >= 0 else path
            if gain < _MIN_GAIN:
                break
    except DeadlineExceeded:
        return path
    return path


def _shortest_free_path(
    points: Array, edges: SteeringEdgeChecker, is_over: Callable[[], bool]
) -> Array | None:
    """Return the waypoints of the shortest free path along some of the points, in their order."""
    begins, ends = np.triu_indices(len(points), 1)
    # With very many points, each has a step from the point before it, but not from all before it.
    stride = -(-len(points) // _MAX_POINTS)
    is_next = ends == begins + 1
    is_candidate = is_next | ((begins % stride == 0) & (ends % stride == 0))
    begins, ends, is_next = begins[is_candidate], ends[is_candidate], is_next[is_candidate]
    tangents, are_free_coarsely = edges.check_coarsely(points[begins], points[ends])
    lengths = edges.norm(tangents).sum(axis=1) + _STEP_COST
    costs = np.full((len(points), len(points)), np.inf)
    costs[begins, ends] = np.where(are_free_coarsely, lengths, np.inf)
    row_of = {
        pair: row for row, pair in enumerate(zip(begins.tolist(), ends.tolist(), strict=True))
    }
    checked_paths: dict[tuple[int, int], Array] = {}
    while True:
        if is_over():
            unchecked = np.isfinite(costs)
            unchecked[begins[is_next], ends[is_next]] = False
            unchecked[tuple(np.array(list(checked_paths), dtype=int).reshape(-1, 2).T)] = False
            costs[unchecked] = np.inf
        chain = _cheapest_chain(costs)
        if chain is None:
            return None
        for i, j in pairwise(chain):
            if (i, j) not in checked_paths:
                path = edges.free_local_path(points[i], points[j], tangents[row_of[i, j]])
                if path is None:
                    costs[i, j] = np.inf
                    break
                checked_paths[i, j] = path
        else:
            return np.concatenate([
                points[:1],
                *(checked_paths[pair][1:] for pair in pairwise(chain)),
            ])


def _cheapest_chain(costs: Array) -> list[int] | None:
    """Return the cheapest path from the first to the last row of an upper triangle of costs."""
    count = len(costs)
    best, predecessors = np.full(count, np.inf), np.zeros(count, dtype=int)
    best[0] = 0.0
    for j in range(1, count):
        totals = best[:j] + costs[:j, j]
        predecessors[j] = int(np.argmin(totals))
        best[j] = totals[predecessors[j]]
    if not np.isfinite(best[-1]):
        return None
    chain = [count - 1]
    while chain[-1]:
        chain.append(int(predecessors[chain[-1]]))
    return chain[::-1]
