"""A way through a roadmap that is there already: start and goals are joined to it for one query.

The cheapest way by the objective is found by A*, which is Dijkstra's algorithm on costs reduced by
what is left to the goals at least (Hart, Nilsson, Raphael 1968). The roadmap stays as it is.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.roadmap import Roadmap
from planning.search.edges import EdgeChecker
from planning.search.graph import Graph, Steps, cheapest_ways, measured, traced
from planning.search.polyline import unrolled
from planning.search.query import Query

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Ends are joined to near states, some at a time and the nearest first, until there are enough ways.
_AT_ONCE = 5
_ENOUGH = 3
_MOST_TRIED = 30
# Goals are joined in portions, the nearest to the start first; further ones if there is no way yet.
_FIRST_PORTION = 3
_PORTION = 8


@dataclass(frozen=True)
class Way:
    """What a roadmap says to a query.

    Attributes:
        reason: Why there is no way, or "".
        graph: The roadmap with the start and the goals that were joined.
        waypoints: From the start to a goal, shape (n, nq); n = 0 without a way.
        goal_row: Which goal, or -1.
    """

    reason: str
    graph: Graph
    waypoints: Float64[np.ndarray, "n nq"]
    goal_row: int


def way_through(roadmap: Roadmap, query: Query, edges: EdgeChecker) -> Way:
    """Return the cheapest way from the start to one of the nearest goals that can be joined.

    Args:
        roadmap: Of the query's group and world.
        query: Where from and where to, and what is free.
        edges: Checks the ways from the ends into the roadmap.

    Raises:
        Canceled: Somebody asked for the end.
        DeadlineExceeded: The time has run out.
    """
    out = _links(roadmap, query.start, edges)
    nothing = Graph(roadmap.states, [], [], lambda _: [])
    none = np.empty((0, len(query.start)))
    if not out:
        return Way("start_not_joined", nothing, none, -1)
    way = Way("goal_not_joined", nothing, none, -1)
    cuts = range(_FIRST_PORTION, len(query.goals), _PORTION)
    for rows in np.split(np.arange(len(query.goals)), cuts):
        links = {row: _links(roadmap, query.goals[row], edges) for row in rows.tolist()}
        joined = {row: into for row, into in links.items() if into}
        if not joined:
            continue
        way = _cheapest(_joined_graph(roadmap, query, out, joined), query, list(joined))
        if not way.reason:
            break
    return way


def _links(roadmap: Roadmap, q: Array, edges: EdgeChecker) -> list[int]:
    """Return the rows of near states to which the way is free."""
    distances = edges.manifold.distance(roadmap.states, q)
    near = np.argsort(distances, kind="stable")[:_MOST_TRIED]
    found: list[int] = []
    for rows in np.split(near, range(_AT_ONCE, len(near), _AT_ONCE)):
        free = edges.are_free(np.tile(q, (len(rows), 1)), roadmap.states[rows])
        found += rows[free].tolist()
        if len(found) >= _ENOUGH:
            break
    return found


def _joined_graph(
    roadmap: Roadmap, query: Query, out: list[int], joined: dict[int, list[int]]
) -> Graph:
    """Return the roadmap with the start as its next row, and the goals after it."""
    start = len(roadmap.states)
    into: dict[int, list[int]] = {}
    for place, links in enumerate(joined.values()):
        for row in links:
            into.setdefault(row, []).append(start + 1 + place)

    def neighbours(row: int) -> list[int]:
        if row < start:
            return [*roadmap.neighbours[row], *into.get(row, ())]
        return out if row == start else []

    goals = list(range(start + 1, start + 1 + len(joined)))
    qs = np.concatenate([roadmap.states, query.start[None], query.goals[list(joined)]])
    return Graph(qs, [start], goals, neighbours)


def _cheapest(graph: Graph, query: Query, rows: list[int]) -> Way:
    goals = set(graph.goals)
    for row, came_from in cheapest_ways(graph, _steps(graph, query)):
        if row in goals:
            waypoints = unrolled(graph.qs[traced(came_from, row)], query.space.manifold)
            return Way("", graph, waypoints, rows[row - graph.goals[0]])
    return Way("no_way", graph, np.empty((0, len(query.start))), -1)


def _steps(graph: Graph, query: Query) -> Steps:
    """Return the costs of edges, less by how much nearer they lead to the nearest goal."""
    objective, manifold = query.objective, query.space.manifold
    costs = measured(graph, objective.edge_costs)
    if objective.name == "clearance":  # where nothing is near, it is less than the length
        return costs
    left = objective.norm(manifold.minus(graph.qs[graph.goals][:, None], graph.qs)).min(axis=0)

    def steps(here: int, there: list[int]) -> list[float]:
        return np.maximum(0.0, costs(here, there) + left[there] - left[here]).tolist()

    return steps
