"""Corridor: the subset of the regions that the graph-of-convex-sets program considers.

A program over all regions takes seconds. So several short paths over the portal centers (portal:
overlap of two regions) are found first, by A*; each path raises the cost of its regions, so that
the next path differs. The corridor is the union of their regions.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

import numpy as np

from planning.domain.arrays import Array
from planning.domain.planner.regions import Regions

# Factor on the cost of a region for each path through it.
_COST_FACTOR = 1.5
# Largest number of paths.
_MAX_PATHS = 12


@dataclass(frozen=True)
class Corridor:
    """Subset of the regions in which a path is searched.

    Attributes:
        rows: Rows of the regions, ascending.
        pairs: Pairs of them that overlap, as indices into `rows`.
        goals: Rows of the goals that the paths reach, in the order of the paths.
    """

    rows: tuple[int, ...]
    pairs: tuple[tuple[int, int], ...]
    goals: tuple[int, ...]


def corridor(
    regions: Regions, start: Array, goals: Sequence[tuple[int, Array]], max_regions: int
) -> Corridor | None:
    """Return regions that connect the start to goals; None if no goal is connected.

    Args:
        regions: All regions and their portals.
        start: Start configuration, in a region, shape (nq,).
        goals: Rows and configurations of the goals, each in a region.
        max_regions: Largest number of regions; the first path is taken whole even if it needs more.
    """
    costs, graph = np.ones(len(regions.regions)), _PortalGraph(regions, start, goals)
    rows: set[int] = set()
    reached: dict[int, None] = {}
    for _ in range(_MAX_PATHS):
        result = graph.shortest_path(costs)
        if result is None:
            return None
        path, goal = result
        if rows and len(rows | set(path)) > max_regions:
            break
        rows |= set(path)
        reached[goal] = None
        costs[path] *= _COST_FACTOR
    ordered = tuple(sorted(rows))
    index_of = {row: index for index, row in enumerate(ordered)}
    pairs = tuple(
        (index_of[i], index_of[j])
        for i, j in (portal.regions for portal in regions.portals)
        if i in index_of and j in index_of
    )
    return Corridor(ordered, pairs, tuple(reached))


class _PortalGraph:
    """Directed graph of the portals, for A*: a vertex is a portal passed in one direction.

    Vertices 2 p and 2 p + 1 lead through portal p, into its second and its first region; the
    vertices after those are goals.
    """

    def __init__(self, regions: Regions, start: Array, goals: Sequence[tuple[int, Array]]) -> None:
        points = [portal.point for portal in regions.portals for _ in range(2)]
        target_regions = [row for portal in regions.portals for row in portal.regions[::-1]]
        exits: list[list[int]] = [[] for _ in regions.regions]
        for vertex in range(len(target_regions)):
            exits[target_regions[vertex ^ 1]].append(vertex)
        self._num_portal_vertices = len(points)
        self._goals = [goal for goal, _ in goals]
        for vertex, (_, q) in enumerate(goals, self._num_portal_vertices):
            points.append(q)
            for row in regions.containing(q):
                exits[row].append(vertex)
        self._start, self._start_regions = start, regions.containing(start)
        self._points, self._target_regions, self._exits = np.stack(points), target_regions, exits
        to_goals = self._points[:, None] - self._points[None, self._num_portal_vertices :]
        self._goal_distances = np.linalg.norm(to_goals, axis=2).min(axis=1)

    def shortest_path(self, costs: Array) -> tuple[list[int], int] | None:
        """Return the regions on the shortest path to a goal, and the goal's row (A*).

        Lengths within a region are multiplied by its cost factor, which is at least 1. None if no
        goal is connected.
        """
        best = np.full(len(self._points), np.inf)
        predecessors: dict[int, tuple[int, int]] = {}
        queue: list[tuple[float, int, float]] = []

        def relax_edges(row: int, vertex: int, point: Array, length: float) -> None:
            neighbors = self._exits[row]
            distances = np.linalg.norm(self._points[neighbors] - point, axis=1)
            for neighbor, cost in zip(neighbors, length + costs[row] * distances, strict=True):
                if cost < best[neighbor]:
                    best[neighbor] = cost
                    predecessors[neighbor] = row, vertex
                    heappush(queue, (cost + self._goal_distances[neighbor], neighbor, cost))

        for row in self._start_regions:
            relax_edges(row, -1, self._start, 0.0)
        while queue:
            _, current, length = heappop(queue)
            if current >= self._num_portal_vertices:
                goal = self._goals[current - self._num_portal_vertices]
                return _trace_path(predecessors, current), goal
            if length <= best[current]:
                relax_edges(self._target_regions[current], current, self._points[current], length)
        return None


def _trace_path(predecessors: dict[int, tuple[int, int]], vertex: int) -> list[int]:
    """Return the rows of the regions along the path to a vertex, from A*'s predecessors."""
    path: list[int] = []
    while vertex >= 0:
        row, vertex = predecessors[vertex]
        path.append(row)
    return path[::-1]
