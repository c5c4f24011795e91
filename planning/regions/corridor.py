"""Which regions a shortest path may pass: those on some short way from portal to portal.

All regions at once make a program that takes seconds. So short ways are looked for first, by
A* from one portal's middle to the next one's; each that is found makes its regions dearer,
so that the next one differs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from typing import Any

import numpy as np

from planning.domain.planner.regions import Regions

type Array = np.ndarray[Any, np.dtype[np.float64]]

# By how much a region that lies on a way is dearer for the next one.
_DEARER = 1.5
# So many ways are looked for at most.
_MOST_WAYS = 12


@dataclass(frozen=True)
class Corridor:
    """Where to look for a path.

    Attributes:
        rows: Of the regions, in order of their rows.
        pairs: Those of them that overlap, as places in `rows`.
        goals: Which goals can be reached, nearest by the first way, as rows of the goals.
    """

    rows: tuple[int, ...]
    pairs: tuple[tuple[int, int], ...]
    goals: tuple[int, ...]


def corridor(
    regions: Regions, start: Array, goals: Sequence[tuple[int, Array]], most: int
) -> Corridor | None:
    """Return at most so many regions that lead to goals, None if none do.

    Args:
        regions: All there are.
        start: In a region, shape (nq,).
        goals: Rows and configurations, each in a region.
        most: Regions; a single way that needs more gets them.
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
    """Ways from portal to portal; a portal that is passed in one direction is a door.

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
        """Return the regions on the shortest way to a goal, and which goal (A*).

        A length within a region is multiplied by the region's price, at least 1.
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
    """Return the regions that were passed on the way to a door."""
    way: list[int] = []
    while door >= 0:
        row, door = before[door]
        way.append(row)
    return way[::-1]
