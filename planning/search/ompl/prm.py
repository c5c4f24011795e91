"""PRM and PRMstar, grown by counts on one thread; queries by Dijkstra's algorithm.

OMPL's own `PRM::solve` searches for solutions on a second thread while the first one grows the
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
from planning.search.ompl.graph import Costs, dijkstra, edge_cost_function, read_graph, trace_path
from planning.search.ompl.spaces import SearchSpace
from planning.search.ompl.termination import TerminationCondition

_FIRST_NUM_SAMPLES = 50


def solve_by_roadmap(
    planner: Any,
    space: SearchSpace,
    termination: TerminationCondition,
    num_goals: int,
    costs: Costs,
) -> Array | None:
    """Return the waypoints of a path, shape (n, nq), or None if `termination` came first.

    For PRMstar, an optimizing planner, the first roadmap with a path is grown to twice its size.
    """
    information = planner.getSpaceInformation()
    definition = planner.getProblemDefinition()
    # Each call with an immediate end connects one more goal, and the first call also the start.
    for _ in range(num_goals):
        planner.solve(ob.plannerAlwaysTerminatingCondition())
    definition.clearSolutionPaths()
    num_samples = _FIRST_NUM_SAMPLES
    while True:
        path = _best_path(planner, information, space, costs)
        if path is not None or termination():
            break
        _grow(planner, termination, num_samples)
        num_samples += num_samples // 2
    if path is not None and isinstance(planner, og.PRMstar):
        termination.extend_oracle_deadline()
        _grow(planner, termination, max(num_samples, planner.milestoneCount()))
        path = _best_path(planner, information, space, costs)
    return path


def is_roadmap_planner(planner: Any) -> bool:
    """Return whether a planner is one of those that this module runs."""
    return hasattr(planner, "growRoadmapPtc")


def _grow(planner: Any, termination: TerminationCondition, count: int) -> None:
    """Add samples until OMPL has queried the termination condition `count` times."""
    planner.growRoadmapPtc(ob.PlannerTerminationCondition(_ends_after(count, termination)))


def _ends_after(count: int, termination: TerminationCondition) -> Callable[[], bool]:
    max_evaluations = termination.num_evaluations + count

    def is_over() -> bool:
        return termination() or termination.num_evaluations >= max_evaluations

    return is_over


def _best_path(planner: Any, information: Any, space: SearchSpace, costs: Costs) -> Array | None:
    graph = read_graph(planner, information, space)
    goals = set(graph.goals)
    for row, came_from in dijkstra(graph, edge_cost_function(graph, costs)):
        if row in goals:
            return graph.qs[trace_path(came_from, row)]
    return None
