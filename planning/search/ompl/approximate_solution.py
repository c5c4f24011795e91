"""Approximate solution: the free path that ends nearest to a goal; evidence of a failure only."""

from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.request.deadline import Deadline
from planning.errors import DeadlineExceeded
from planning.search.collision_oracle import WatchedOracle
from planning.search.edges import EdgeChecker
from planning.search.ompl.graph import Graph, dijkstra, edge_cost_function, trace_path
from planning.search.ompl.spaces import SearchSpace

# Time budget after the search has run out of time [s].
_GRACE_PERIOD = 0.15


def approximate_solution(
    graph: Graph,
    space: SearchSpace,
    goals: Array,
    checker: EdgeChecker,
    oracle: WatchedOracle,
    deadline: Deadline,
) -> dict[str, Any] | None:
    """Return the reachable configuration nearest to a goal, or None if there is none.

    Every edge is checked again, since some planners check late; the path ends before the first
    blocked edge.

    Args:
        graph: Graph that the planner explored.
        space: State space of the search.
        goals: Goal configurations, shape (n, nq).
        checker: Checker of edges at the fine resolution, by the oracle.
        oracle: Its oracle.
        deadline: Deadline of the plan; it may have passed.

    Returns:
        `positions` of that configuration, the `path` to it, and the `goal` at the distance
            `goal_distance` (joint-space length).
    """
    grace_deadline = Deadline.after(_GRACE_PERIOD, deadline.clock, deadline.is_canceled)
    came_from: dict[int, int] = {}
    reached: list[int] = []
    for row, table in dijkstra(graph, edge_cost_function(graph, space.manifold.distance)):
        reached.append(row)
        came_from = table
    if not reached:
        return None
    distances = space.manifold.distance(graph.qs[reached][:, None], goals[None])
    nearest = reached[int(np.argmin(distances.min(axis=1)))]
    path = graph.qs[trace_path(came_from, nearest)]
    try:
        with oracle.with_deadline(grace_deadline):
            free = checker.are_free(path[:-1], path[1:]) if len(path) > 1 else np.ones(0, bool)
    except DeadlineExceeded:
        return None
    path = path[: 1 + int(np.argmin(np.append(free, [False])))]
    ends = space.manifold.distance(path[:, None], goals[None])
    last, goal = np.unravel_index(int(np.argmin(ends)), ends.shape)
    return {
        "positions": path[last].tolist(),
        "path": path[: last + 1].tolist(),
        "goal_distance": float(ends[last, goal]),
        "goal": goals[goal].tolist(),
    }
