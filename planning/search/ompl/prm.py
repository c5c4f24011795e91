"""PRM and PRMstar, grown by counts on one thread; queries by Dijkstra's algorithm.

OMPL's own `PRM::solve` looks for solutions on a second thread while the first one grows the
roadmap, and changes its growth strategy by the clock. With checks in Python the two threads
deadlock, and without them the result would depend on the scheduler. So OMPL connects the start, the
goals and the samples, and this module computes the cheapest path through them by Dijkstra's
algorithm, each time the roadmap has grown by half.
"""

from collections.abc import Callable
from typing import Any

from ompl import base as ob
from ompl import geometric as og

from planning.domain.arrays import Array
from planning.search.ompl.graph import Costs, cheapest_ways, measured, read_graph, traced
from planning.search.ompl.spaces import SearchSpace
from planning.search.ompl.termination import TerminationCondition

_FIRST_GROWTH = 50


def solve_by_roadmap(
    planner: Any, space: SearchSpace, stopping: TerminationCondition, num_goals: int, costs: Costs
) -> Array | None:
    """Return the waypoints of a path, shape (n, nq), or None if `stopping` came first.

    For PRMstar, an optimising planner, the first roadmap with a path is grown to twice its size.
    """
    information = planner.getSpaceInformation()
    definition = planner.getProblemDefinition()
    # Each call with an immediate end connects one more goal, and the first call also the start.
    for _ in range(num_goals):
        planner.solve(ob.plannerAlwaysTerminatingCondition())
    definition.clearSolutionPaths()
    growth = _FIRST_GROWTH
    while True:
        path = _best_path(planner, information, space, costs)
        if path is not None or stopping():
            break
        _grow(planner, stopping, growth)
        growth += growth // 2
    if path is not None and isinstance(planner, og.PRMstar):
        stopping.keep_solution()
        _grow(planner, stopping, max(growth, planner.milestoneCount()))
        path = _best_path(planner, information, space, costs)
    return path


def is_roadmap_planner(planner: Any) -> bool:
    """Return whether a planner is one of those that this module runs."""
    return hasattr(planner, "growRoadmapPtc")


def _grow(planner: Any, stopping: TerminationCondition, count: int) -> None:
    """Add samples until OMPL has queried the termination condition `count` times."""
    planner.growRoadmapPtc(ob.PlannerTerminationCondition(_after(count, stopping)))


def _after(count: int, stopping: TerminationCondition) -> Callable[[], bool]:
    last = stopping.questions + count

    def is_enough() -> bool:
        return stopping() or stopping.questions >= last

    return is_enough


def _best_path(planner: Any, information: Any, space: SearchSpace, costs: Costs) -> Array | None:
    graph = read_graph(planner, information, space)
    goals = set(graph.goals)
    for row, came_from in cheapest_ways(graph, measured(graph, costs)):
        if row in goals:
            return graph.qs[traced(came_from, row)]
    return None
