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
_DEARER = 1.5
# Largest number of paths.
_MOST_WAYS = 12


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
    regions: Regions, start: Array, goals: Sequence[tuple[int, Array]], most: int
) -> Corridor | None:
    """Return regions that connect the start to goals; None if no goal is connected.

    Args:
        regions: All regions and their portals.
        start: Start configuration, in a region, shape (nq,).
        goals: Rows and configurations of the goals, each in a region.
        most: Largest number of regions; the first path is taken whole even if it needs more.
    """
    prices, ways = np.ones(len(regions.regions)), _Ways(regions, start, goals)
    rows: set[int] = set()
    reached: dict[int, None] = {}
    for _ in range(_MOST_WAYS):
        found = ways.shortest(prices)
        if found is None:
            return None
        way, goal = found
        if rows and len(rows | set(way)) > most:
            break
        rows |= set(way)
        reached[goal] = None
        prices[way] *= _DEARER
    ordered = tuple(sorted(rows))
    places = {row: place for place, row in enumerate(ordered)}
    pairs = tuple(
        (places[i], places[j])
        for i, j in (portal.regions for portal in regions.portals)
        if i in places and j in places
    )
    return Corridor(ordered, pairs, tuple(reached))


class _Ways:
    """Directed graph of the portals, for A*: a vertex (door) is a portal passed in one direction.

    Doors 2 p and 2 p + 1 lead through portal p, into its second and its first region; the doors
    after those are goals.
    """

    def __init__(self, regions: Regions, start: Array, goals: Sequence[tuple[int, Array]]) -> None:
        places = [portal.point for portal in regions.portals for _ in range(2)]
        enters = [row for portal in regions.portals for row in portal.regions[::-1]]
        leaves: list[list[int]] = [[] for _ in regions.regions]
        for door in range(len(enters)):
            leaves[enters[door ^ 1]].append(door)
        self._num_doors = len(places)
        self._goals = [goal for goal, _ in goals]
        for door, (_, q) in enumerate(goals, self._num_doors):
            places.append(q)
            for row in regions.containing(q):
                leaves[row].append(door)
        self._start, self._first = start, regions.containing(start)
        self._places, self._enters, self._leaves = np.stack(places), enters, leaves
        to_goals = self._places[:, None] - self._places[None, self._num_doors :]
        self._ahead = np.linalg.norm(to_goals, axis=2).min(axis=1)

    def shortest(self, prices: Array) -> tuple[list[int], int] | None:
        """Return the regions on the shortest path to a goal, and the goal's row (A*).

        Lengths within a region are multiplied by the region's price, which is at least 1. None if
        no goal is connected.
        """
        best = np.full(len(self._places), np.inf)
        before: dict[int, tuple[int, int]] = {}
        queue: list[tuple[float, int, float]] = []

        def leave(row: int, door: int, at: Array, length: float) -> None:
            doors = self._leaves[row]
            steps = np.linalg.norm(self._places[doors] - at, axis=1)
            for following, so_far in zip(doors, length + prices[row] * steps, strict=True):
                if so_far < best[following]:
                    best[following] = so_far
                    before[following] = row, door
                    heappush(queue, (so_far + self._ahead[following], following, so_far))

        for row in self._first:
            leave(row, -1, self._start, 0.0)
        while queue:
            _, door, length = heappop(queue)
            if door >= self._num_doors:
                return _traced(before, door), self._goals[door - self._num_doors]
            if length <= best[door]:
                leave(self._enters[door], door, self._places[door], length)
        return None


def _traced(before: dict[int, tuple[int, int]], door: int) -> list[int]:
    """Return the rows of the regions along the path to a door, from A*'s predecessors."""
    way: list[int] = []
    while door >= 0:
        row, door = before[door]
        way.append(row)
    return way[::-1]
