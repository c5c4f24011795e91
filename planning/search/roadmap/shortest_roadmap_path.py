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
from planning.search.ompl.graph import Graph, Steps, dijkstra, edge_cost_function, trace_path
from planning.search.ompl.projected_space import ProjectedSpace
from planning.search.query import Query
from planning.search.roadmap.local_planner import LocalPlanner
from planning.search.shortcut.polyline import unwrap

# The start and each goal are connected to near states, a batch at a time and the nearest first:
# batch size, sufficient number of connections, and most states tried.
_LINK_BATCH = 5
_SUFFICIENT_LINKS = 3
_MAX_LINK_CANDIDATES = 30
# Goals are connected in batches, the nearest to the start first; more of them if there is no path.
_FIRST_GOAL_BATCH = 3
_GOAL_BATCH = 8


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
class _RoadmapLinks:
    """Connections of the start and of some goals to a roadmap.

    Attributes:
        start_links: Waypoints between the start and a state, by the state's row in the roadmap.
        goal_links: Goal connections likewise, by the goal's row among the goals.
    """

    start_links: dict[int, Array]
    goal_links: dict[int, dict[int, Array]]


def shortest_roadmap_path(roadmap: Roadmap, query: Query, edges: EdgeChecker) -> RoadmapPath:
    """Return the cheapest path from the start to one of the nearest goals that can be connected.

    Args:
        roadmap: Roadmap of the query's group and world.
        query: Start, goals and collision oracle.
        edges: Checker of the connections to the roadmap.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    space = query.space
    local_planner = LocalPlanner(
        edges, space.residual if isinstance(space, ProjectedSpace) else None
    )
    start_links = _links(roadmap, query.start, local_planner)
    empty_graph = Graph(roadmap.states, [], [], lambda _: [])
    no_waypoints = np.empty((0, len(query.start)))
    if not start_links:
        return RoadmapPath("start_not_joined", empty_graph, no_waypoints, -1)
    path = RoadmapPath("goal_not_joined", empty_graph, no_waypoints, -1)
    cuts = range(_FIRST_GOAL_BATCH, len(query.goals), _GOAL_BATCH)
    for rows in np.split(np.arange(len(query.goals)), cuts):
        goal_links = {
            row: _links(roadmap, query.goals[row], local_planner) for row in rows.tolist()
        }
        roadmap_links = _RoadmapLinks(
            start_links, {row: links for row, links in goal_links.items() if links}
        )
        if not roadmap_links.goal_links:
            continue
        path = _cheapest_path(
            _graph_with_links(roadmap, query, roadmap_links), query, roadmap_links, edges
        )
        if not path.reason:
            break
    return path


def _links(roadmap: Roadmap, q: Array, local_planner: LocalPlanner) -> dict[int, Array]:
    """Return the rows of near states with a free connection, and the waypoints between."""
    nearest = local_planner.nearest(roadmap.states, q, _MAX_LINK_CANDIDATES)
    links: dict[int, Array] = {}
    for rows in np.split(nearest, range(_LINK_BATCH, len(nearest), _LINK_BATCH)):
        connections = local_planner.connections(np.tile(q, (len(rows), 1)), roadmap.states[rows])
        pairs = zip(rows.tolist(), connections, strict=True)
        links |= {row: waypoints for row, waypoints in pairs if waypoints is not None}
        if len(links) >= _SUFFICIENT_LINKS:
            break
    return links


def _graph_with_links(roadmap: Roadmap, query: Query, roadmap_links: _RoadmapLinks) -> Graph:
    """Return the roadmap with the start as its next row, and the goals after it."""
    start = len(roadmap.states)
    start_rows = list(roadmap_links.start_links)
    goals_by_row: dict[int, list[int]] = {}
    for index, links in enumerate(roadmap_links.goal_links.values()):
        for row in links:
            goals_by_row.setdefault(row, []).append(start + 1 + index)

    def neighbours(row: int) -> list[int]:
        if row < start:
            return [*roadmap.neighbours[row], *goals_by_row.get(row, ())]
        return start_rows if row == start else []

    goals = list(range(start + 1, start + 1 + len(roadmap_links.goal_links)))
    qs = np.concatenate([
        roadmap.states,
        query.start[None],
        query.goals[list(roadmap_links.goal_links)],
    ])
    return Graph(qs, [start], goals, neighbours)


def _cheapest_path(
    graph: Graph, query: Query, roadmap_links: _RoadmapLinks, edges: EdgeChecker
) -> RoadmapPath:
    goals = set(graph.goals)
    for row, came_from in dijkstra(graph, _reduced_costs(graph, query, edges)):
        if row in goals:
            goal_row = list(roadmap_links.goal_links)[row - graph.goals[0]]
            waypoints = _waypoints_with_links(
                graph,
                trace_path(came_from, row),
                roadmap_links.start_links,
                roadmap_links.goal_links[goal_row],
            )
            waypoints = unwrap(waypoints, query.space.manifold)
            if isinstance(query.space, CarSpace):
                waypoints = query.space.steering_paths.waypoints_through(waypoints)
            return RoadmapPath("", graph, waypoints, goal_row)
    return RoadmapPath("no_way", graph, np.empty((0, len(query.start))), -1)


def _waypoints_with_links(
    graph: Graph, rows: list[int], start_links: dict[int, Array], goal_links: dict[int, Array]
) -> Array:
    """Return the waypoints of a path, with those of the connections at both ends."""
    first, last = start_links[rows[1]], goal_links[rows[-2]][::-1]
    parts = [graph.qs[rows[:1]], first, graph.qs[rows[1:-1]], last, graph.qs[rows[-1:]]]
    return np.concatenate(parts)


def _reduced_costs(graph: Graph, query: Query, edges: EdgeChecker) -> Steps:
    """Return the costs of edges, reduced by the decrease of the lower bound to the nearest goal."""
    objective, manifold = query.objective, query.space.manifold
    if isinstance(edges, SteeringEdgeChecker):
        # For steering paths a lower bound takes longer to compute than it saves.
        return edge_cost_function(graph, edges.lengths)
    costs = edge_cost_function(graph, objective.edge_costs)
    if objective.name == "clearance":  # can be less than the length: no lower bound
        return costs
    lower_bound = objective.norm(manifold.minus(graph.qs[graph.goals][:, None], graph.qs)).min(
        axis=0
    )

    def reduced_costs(here: int, there: list[int]) -> list[float]:
        return np.maximum(0.0, costs(here, there) + lower_bound[there] - lower_bound[here]).tolist()

    return reduced_costs
