"""Which regions a shortest path may pass: those on some short way from portal to portal.

All regions at once make a program that takes seconds. So short ways are looked for first, by
Dijkstra from one portal's middle to the next one's; each that is found makes its regions dearer,
so that the next one differs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count
from typing import Any

import numpy as np

from planning.domain.regions import Regions

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


@dataclass(frozen=True)
class _Step:
    """Somewhere to go within a region: to a portal, or to a goal.

    Attributes:
        at: Where that is, shape (nq,).
        row: The region that is entered there, or -1.
        goal: The row of the goal that is there, or -1.
    """

    at: Array
    row: int
    goal: int = -1


class _Ways:
    """Ways from portal to portal."""

    def __init__(self, regions: Regions, start: Array, goals: Sequence[tuple[int, Array]]) -> None:
        self._start = start
        self._first = regions.containing(start)
        self._steps: dict[int, list[_Step]] = {row: [] for row in range(len(regions.regions))}
        for portal in regions.portals:
            for here, there in (portal.regions, portal.regions[::-1]):
                self._steps[here].append(_Step(portal.point, there))
        for goal, q in goals:
            for row in regions.containing(q):
                self._steps[row].append(_Step(q, -1, goal))

    def shortest(self, prices: Array) -> tuple[list[int], int] | None:
        """Return the regions on the shortest way to a goal, and which goal (Dijkstra).

        A length within a region is multiplied by the region's price.
        """
        ticket = count()
        queue = [(0.0, next(ticket), _Step(self._start, row), [row]) for row in self._first]
        done: set[tuple[int, bytes]] = set()
        while queue:
            length, _, step, way = heappop(queue)
            if step.goal >= 0:
                return way, step.goal
            key = step.row, step.at.tobytes()
            if key in done:
                continue
            done.add(key)
            for following in self._steps[step.row]:
                if following.row not in way:
                    cost = prices[step.row] * float(np.linalg.norm(following.at - step.at))
                    longer = way if following.goal >= 0 else [*way, following.row]
                    heappush(queue, (length + cost, next(ticket), following, longer))
        return None
