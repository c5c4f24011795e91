"""Graph: a planner's explored graph as arrays, and shortest paths in it (Dijkstra)."""

import heapq
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from ompl import base as ob
from ompl import geometric as og

from planning.domain.arrays import Array
from planning.domain.planner.planner_graph import PlannerGraph
from planning.search.ompl.spaces import SearchSpace

type Costs = Callable[[Array, Array], Array]
# Costs of the edges from a row to its neighbours, in their order.
type Steps = Callable[[int, list[int]], Array | list[float]]

# Limits on a graph for display: more is neither drawn nor sent.
_MAX_VERTICES = 2_000
_MAX_EDGES = 10_000
_VERTEX_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Graph:
    """Planner's explored graph; an edge points from the root of a tree outwards.

    Attributes:
        qs: Vertices, shape (n, nq).
        starts: Rows of starts.
        goals: Rows of goals.
        neighbours: Returns the rows that edges from a row lead to.
    """

    qs: Float64[np.ndarray, "n nq"]
    starts: list[int]
    goals: list[int]
    neighbours: Callable[[int], list[int]]


def has_graph(planner: Any) -> bool:
    """Return whether a planner's graph can be read.

    Reading BITstar's leaks the whole space information; AORRTC's is empty (OMPL 2.0.1).
    """
    return not isinstance(planner, og.BITstar | og.AORRTC)


def read_graph(planner: Any, information: Any, space: SearchSpace) -> Graph:
    """Return the graph of a planner that has one."""
    graph = ob.PlannerData(information)
    planner.getPlannerData(graph)
    rows = range(graph.numVertices())
    qs = np.array([space.read(graph.getVertex(i).getState()) for i in rows])
    return Graph(
        qs.reshape(len(rows), space.manifold.num_positions),
        [graph.getStartIndex(i) for i in range(graph.numStartVertices())],
        [graph.getGoalIndex(i) for i in range(graph.numGoalVertices())],
        graph.getEdges,
    )


def with_query_vertices(graph: Graph, start: Array, goals: Array, space: SearchSpace) -> Graph:
    """Return the same graph with its start and goals found by position, and undirected edges.

    FMT reports every vertex without a parent as a start, BFMT reports none (OMPL 2.0.1), and
    planners differ in the direction of edges.
    """
    if not len(graph.qs):
        return graph
    neighbours: list[list[int]] = [[] for _ in graph.qs]
    for i in range(len(graph.qs)):
        for j in graph.neighbours(i):
            neighbours[i].append(j)
            neighbours[j].append(i)
    starts, ends = (
        [row for q in qs if (row := _row_of(q, graph, space)) is not None]
        for qs in (start[None], goals)
    )
    return Graph(graph.qs, starts, ends, neighbours.__getitem__)


def edge_cost_function(graph: Graph, costs: Costs) -> Callable[[int, list[int]], Array]:
    """Return the costs of a graph's edges, computed on demand."""
    return lambda here, there: costs(graph.qs[there], graph.qs[here])


def dijkstra(graph: Graph, edge_costs: Steps) -> Iterator[tuple[int, dict[int, int]]]:
    """Yield vertices reachable from the first start, cheapest first (Dijkstra's algorithm).

    With each row comes the table of predecessors by row; a start is its own predecessor.
    """
    if not graph.starts:
        return
    start = graph.starts[0]
    best = [math.inf] * len(graph.qs)
    best[start] = 0.0
    came_from = {start: start}
    queue = [(0.0, start)]
    while queue:
        cost, here = heapq.heappop(queue)
        if cost > best[here]:
            continue
        yield here, came_from
        neighbours = graph.neighbours(here)
        costs = edge_costs(here, neighbours) if neighbours else ()
        for there, edge_cost in zip(neighbours, costs, strict=True):
            if cost + edge_cost < best[there]:
                best[there] = cost + edge_cost
                came_from[there] = here
                heapq.heappush(queue, (best[there], there))


def trace_path(came_from: dict[int, int], end: int) -> list[int]:
    """Return the rows from the start to `end`, by the table of predecessors."""
    chain = [end]
    while came_from[chain[-1]] != chain[-1]:
        chain.append(came_from[chain[-1]])
    return chain[::-1]


def export_graph(
    name: str, graph: Graph, space: SearchSpace, solution: Float64[np.ndarray, "m nq"]
) -> PlannerGraph:
    """Return a graph for display, which always contains the solution, the starts and the goals.

    Args:
        name: Name of the planner.
        graph: Explored graph.
        space: State space of the search.
        solution: Path of the planner, shape (m, nq); m = 0 for none.
    """
    rows = [_row_of(q, graph, space) for q in solution] if len(graph.qs) else []
    path = [row for row in rows if row is not None]
    ordered_rows = dict.fromkeys([*graph.starts, *graph.goals, *path, *range(len(graph.qs))])
    exported_rows = sorted(list(ordered_rows)[:_MAX_VERTICES])
    index_of = {row: i for i, row in enumerate(exported_rows)}
    pairs = {
        (min(i, j), max(i, j)) for i in range(len(graph.qs)) for j in graph.neighbours(i) if i != j
    }
    edges = sorted((index_of[i], index_of[j]) for i, j in pairs if i in index_of and j in index_of)
    return PlannerGraph(
        planner=name,
        vertices=graph.qs[exported_rows],
        edges=tuple(edges[:_MAX_EDGES]),
        starts=tuple(index_of[row] for row in graph.starts if row in index_of),
        goals=tuple(index_of[row] for row in graph.goals if row in index_of),
        path=tuple(index_of[row] for row in path if row in index_of),
        num_vertices=len(graph.qs),
        num_edges=len(pairs),
    )


def line_graph(waypoints: Float64[np.ndarray, "2 nq"]) -> PlannerGraph:
    """Return the graph of a free straight line, for which no planner was used."""
    return PlannerGraph("", waypoints, ((0, 1),), (0,), (1,), (0, 1), 2, 1)


def _row_of(q: Array, graph: Graph, space: SearchSpace) -> int | None:
    distances = space.manifold.distance(graph.qs, q)
    row = int(np.argmin(distances))
    return row if distances[row] < _VERTEX_TOLERANCE else None
