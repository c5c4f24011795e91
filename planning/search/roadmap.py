"""Roadmap planners (PRM, PRMstar), grown by counts on one thread.

OMPL's own `PRM::solve` looks for solutions on a second thread while the first one grows the
roadmap, and changes its way of growing by the clock. With checks in Python the two threads wait
for each other for ever, and without them the result would depend on the scheduler. So OMPL
connects the start, the goals and the samples, and the shortest way through them is looked for here,
by Dijkstra's algorithm, each time the roadmap has grown by half.
"""

import heapq
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import geometric as og

from planning.search.spaces import SearchSpace
from planning.search.stopping import Stopping

type Array = np.ndarray[Any, np.dtype[np.float64]]

_FIRST_GROWTH = 50


def solve_by_roadmap(
    planner: Any, information: Any, space: SearchSpace, stopping: Stopping, num_goals: int
) -> Array | None:
    """Return the waypoints of a path, shape (n, nq), or None if `stopping` came first.

    PRMstar, which is asked for good paths, grows its first successful roadmap to twice its size.
    """
    definition = planner.getProblemDefinition()
    # Each call that must end at once connects one more goal, and the first one the start.
    for _ in range(num_goals):
        planner.solve(ob.plannerAlwaysTerminatingCondition())
    definition.clearSolutionPaths()
    growth = _FIRST_GROWTH
    while True:
        path = _shortest_path(planner, information, space)
        if path is not None or stopping():
            break
        _grow(planner, stopping, growth)
        growth += growth // 2
    if path is not None and isinstance(planner, og.PRMstar):
        _grow(planner, stopping, max(growth, planner.milestoneCount()))
        path = _shortest_path(planner, information, space)
    return path


def is_roadmap_planner(planner: Any) -> bool:
    """Return whether a planner has to be driven from here."""
    return hasattr(planner, "growRoadmapPtc")


def _grow(planner: Any, stopping: Stopping, count: int) -> None:
    """Sample until OMPL has asked `count` times whether to stop."""
    planner.growRoadmapPtc(ob.PlannerTerminationCondition(_after(count, stopping)))


def _after(count: int, stopping: Stopping) -> Callable[[], bool]:
    last = stopping.questions + count

    def is_enough() -> bool:
        return stopping() or stopping.questions >= last

    return is_enough


def _shortest_path(planner: Any, information: Any, space: SearchSpace) -> Array | None:
    graph = ob.PlannerData(information)
    planner.getPlannerData(graph)
    qs = np.array([space.read(graph.getVertex(i).getState()) for i in range(graph.numVertices())])
    goals = {graph.getGoalIndex(i) for i in range(graph.numGoalVertices())}
    start = graph.getStartIndex(0)
    best = [math.inf] * len(qs)
    best[start] = 0.0
    came_from = {start: start}
    queue = [(0.0, start)]
    while queue:
        length, here = heapq.heappop(queue)
        if here in goals:
            return qs[_trace(came_from, here)]
        if length > best[here]:
            continue
        neighbours = graph.getEdges(here)
        steps = space.manifold.distance(qs[neighbours], qs[here]) if neighbours else ()
        for there, step in zip(neighbours, steps, strict=True):
            if length + step < best[there]:
                best[there] = length + step
                came_from[there] = here
                heapq.heappush(queue, (best[there], there))
    return None


def _trace(came_from: dict[int, int], end: int) -> list[int]:
    chain = [end]
    while came_from[chain[-1]] != chain[-1]:
        chain.append(came_from[chain[-1]])
    return chain[::-1]
