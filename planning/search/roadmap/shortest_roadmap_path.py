"""Shortest path through an existing roadmap; start and goals are connected to it for one query.

The cheapest path by the objective is found by A*: Dijkstra's algorithm on costs reduced by a lower
bound of the remaining cost (Hart, Nilsson, Raphael 1968). The roadmap itself is not changed.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.planner.roadmap import Roadmap
from planning.search.cars.steering_edges import SteeringEdgeChecker
from planning.search.edges import EdgeChecker
from planning.search.ompl.car_space import CarSpace
from planning.search.ompl.graph import Graph, Steps, cheapest_ways, measured, traced
from planning.search.ompl.projected_space import ProjectedSpace
from planning.search.query import Query
from planning.search.roadmap.local_planner import LocalPlanner
from planning.search.shortcut.polyline import unrolled

# The start and each goal are connected to near states, a batch at a time and the nearest first:
# batch size, sufficient number of connections, and most states tried.
_AT_ONCE = 5
_ENOUGH = 3
_MOST_TRIED = 30
# Goals are connected in batches, the nearest to the start first; more of them if there is no path.
_FIRST_PORTION = 3
_PORTION = 8


@dataclass(frozen=True)
class RoadmapPath:
    """Result of a roadmap query.

    Attributes:
        reason: Why there is no path, or "".
        graph: The roadmap with the start and the goals that were connected.
        waypoints: From the start to a goal, shape (n, nq); n = 0 without a path.
        goal_row: Row of that goal, or -1.
    """

    reason: str
    graph: Graph
    waypoints: Float64[np.ndarray, "n nq"]
    goal_row: int


@dataclass(frozen=True)
class _Ends:
    """Connections of the start and of some goals to a roadmap.

    Attributes:
        out: Waypoints between the start and a state, by the state's row in the roadmap.
        into: Goal connections likewise, by the goal's row among the goals.
    """

    out: dict[int, Array]
    into: dict[int, dict[int, Array]]


def shortest_roadmap_path(roadmap: Roadmap, query: Query, edges: EdgeChecker) -> RoadmapPath:
    """Return the cheapest path from the start to one of the nearest goals that can be connected.

    Args:
        roadmap: Of the query's group and world.
        query: Start, goals and collision oracle.
        edges: Checker of the connections to the roadmap.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    space = query.space
    joining = LocalPlanner(edges, space.residual if isinstance(space, ProjectedSpace) else None)
    out = _links(roadmap, query.start, joining)
    nothing = Graph(roadmap.states, [], [], lambda _: [])
    none = np.empty((0, len(query.start)))
    if not out:
        return RoadmapPath("start_not_joined", nothing, none, -1)
    way = RoadmapPath("goal_not_joined", nothing, none, -1)
    cuts = range(_FIRST_PORTION, len(query.goals), _PORTION)
    for rows in np.split(np.arange(len(query.goals)), cuts):
        links = {row: _links(roadmap, query.goals[row], joining) for row in rows.tolist()}
        ends = _Ends(out, {row: into for row, into in links.items() if into})
        if not ends.into:
            continue
        way = _cheapest(_joined_graph(roadmap, query, ends), query, ends, edges)
        if not way.reason:
            break
    return way


def _links(roadmap: Roadmap, q: Array, joining: LocalPlanner) -> dict[int, Array]:
    """Return the rows of near states with a free connection, and the waypoints between."""
    near = joining.nearest(roadmap.states, q, _MOST_TRIED)
    found: dict[int, Array] = {}
    for rows in np.split(near, range(_AT_ONCE, len(near), _AT_ONCE)):
        between = joining.between(np.tile(q, (len(rows), 1)), roadmap.states[rows])
        pairs = zip(rows.tolist(), between, strict=True)
        found |= {row: waypoints for row, waypoints in pairs if waypoints is not None}
        if len(found) >= _ENOUGH:
            break
    return found


def _joined_graph(roadmap: Roadmap, query: Query, ends: _Ends) -> Graph:
    """Return the roadmap with the start as its next row, and the goals after it."""
    start = len(roadmap.states)
    out = list(ends.out)
    into: dict[int, list[int]] = {}
    for place, links in enumerate(ends.into.values()):
        for row in links:
            into.setdefault(row, []).append(start + 1 + place)

    def neighbours(row: int) -> list[int]:
        if row < start:
            return [*roadmap.neighbours[row], *into.get(row, ())]
        return out if row == start else []

    goals = list(range(start + 1, start + 1 + len(ends.into)))
    qs = np.concatenate([roadmap.states, query.start[None], query.goals[list(ends.into)]])
    return Graph(qs, [start], goals, neighbours)


def _cheapest(graph: Graph, query: Query, ends: _Ends, edges: EdgeChecker) -> RoadmapPath:
    goals = set(graph.goals)
    for row, came_from in cheapest_ways(graph, _steps(graph, query, edges)):
        if row in goals:
            goal_row = list(ends.into)[row - graph.goals[0]]
            waypoints = _whole(graph, traced(came_from, row), ends.out, ends.into[goal_row])
            waypoints = unrolled(waypoints, query.space.manifold)
            if isinstance(query.space, CarSpace):
                waypoints = query.space.drives.threaded(waypoints)
            return RoadmapPath("", graph, waypoints, goal_row)
    return RoadmapPath("no_way", graph, np.empty((0, len(query.start))), -1)


def _whole(graph: Graph, rows: list[int], out: dict[int, Array], into: dict[int, Array]) -> Array:
    """Return the waypoints of a path, with those of the connections at both ends."""
    first, last = out[rows[1]], into[rows[-2]][::-1]
    parts = [graph.qs[rows[:1]], first, graph.qs[rows[1:-1]], last, graph.qs[rows[-1:]]]
    return np.concatenate(parts)


def _steps(graph: Graph, query: Query, edges: EdgeChecker) -> Steps:
    """Return the costs of edges, reduced by the decrease of the lower bound to the nearest goal."""
    objective, manifold = query.objective, query.space.manifold
    if isinstance(edges, SteeringEdgeChecker):
        # For steering paths a lower bound takes longer to compute than it saves.
        return measured(graph, edges.lengths)
    costs = measured(graph, objective.edge_costs)
    if objective.name == "clearance":  # can be less than the length: no lower bound
        return costs
    left = objective.norm(manifold.minus(graph.qs[graph.goals][:, None], graph.qs)).min(axis=0)

    def steps(here: int, there: list[int]) -> list[float]:
        return np.maximum(0.0, costs(here, there) + left[there] - left[here]).tolist()

    return steps
