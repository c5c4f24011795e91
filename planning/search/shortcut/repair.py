"""Repair of a path: its blocked edges are replaced by local searches between their ends.

Usually a planner whose path collides at the fine resolution starts anew with a finer one. After a
cancel there is no time for that; and optimized paths are so close to obstacles that a finer
resolution hardly helps. But most of such a path is free: only its blocked edges are replaced, each
by a path of RRTConnect between their ends.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.search.edges import EdgeChecker
from planning.search.ompl.car_space import CarSpace
from planning.search.ompl.run_planner import run_planner
from planning.search.query import Query

# Time budget after a cancel, all edges together [s].
_CANCELED_REPAIR_TIME = 0.3
# Checked states per edge: counts and not seconds decide, unless the request was canceled.
_MAX_CHECKED_STATES = 4_000


def repair_path(
    query: Query, waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker, seed: int
) -> Array | None:
    """Return a path of free edges with the same ends, shape (m, nq), or None if there is none soon.

    None for cars, whose waypoints are too close to one another for a detour between them.

    Args:
        query: Search problem.
        waypoints: From start to goal.
        edges: Checker of edges at the fine resolution.
        seed: Seed of OMPL's random numbers.

    Raises:
        DeadlineExceeded: The time of the whole search has run out.
    """
    if isinstance(query.space, CarSpace):
        return None
    repair_deadline = (
        query.completion_deadline.within(_CANCELED_REPAIR_TIME)
        if query.is_canceled_keeping_best
        else query.deadline
    )
    pieces = [waypoints[:1]]
    with query.oracle.with_deadline(query.completion_deadline):
        free = edges.are_free(waypoints[:-1], waypoints[1:])
        for ends, is_free in zip(pairwise(waypoints), free, strict=True):
            edge_path = np.stack(ends)
            if not is_free:
                edge_query = _make_edge_query(query, edge_path, repair_deadline.remaining)
                edge_path = run_planner(edge_query, edges, edges, seed).waypoints
            if not len(edge_path):
                return None
            pieces.append(edge_path[1:])
    return np.concatenate(pieces)


def _make_edge_query(query: Query, ends: Array, seconds: float) -> Query:
    """Return the search problem from one waypoint to the next."""
    return replace(
        query,
        start=ends[0],
        goals=ends[1:],
        planner="RRTConnect",
        parameters={},
        deadline=query.completion_deadline,
        options=replace(
            query.options,
            setup_time=None,
            solve_time=seconds,
            keep_graph=False,
            approximate=False,
        ),
        max_checked_states=_MAX_CHECKED_STATES,
        on_improvement=None,
    )
