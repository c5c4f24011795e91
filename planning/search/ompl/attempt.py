"""Attempt: one run of an OMPL planner, from an empty graph."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from jaxtyping import Float64
from ompl import base as ob
from ompl import util as ou

from planning.domain.arrays import Array
from planning.domain.planner.planner_graph import PlannerGraph
from planning.domain.value import Value
from planning.errors import DeadlineExceeded
from planning.search.edges import EdgeChecker
from planning.search.ompl.approximate_solution import approximate_solution
from planning.search.ompl.car_space import CarSpace
from planning.search.ompl.graph import Graph, between, exported, has_graph, read_graph
from planning.search.ompl.planner_list import make_planner
from planning.search.ompl.prm import is_roadmap_planner, solve_by_roadmap
from planning.search.ompl.projected_space import ProjectedSpace
from planning.search.ompl.spaces import SearchSpace
from planning.search.ompl.termination import TerminationCondition
from planning.search.ompl.validity import space_information
from planning.search.query import Query
from planning.search.shortcut.polyline import unrolled

# Largest distance of a path's end from a goal: the planner copies the goal's state.
_SAME = 1e-6


@dataclass(frozen=True, eq=False)
class Attempt(Value):
    """Result of one run of a planner.

    Attributes:
        status: OMPL's status string; "setup" if the setup took all of its time.
        waypoints: From the start to a goal, shape (n, nq); n = 0 without an exact solution.
        goal_row: Row of that goal, or -1.
        growth: Evidence of a failure: `num_vertices` and `num_edges` of its trees or roadmap, and
            `goal_distance`, the least distance to a goal in OMPL's metric, None where the planner
            has no such value. `approximate` and `graph` on request. After a setup that took too
            long: `reason`, `during`, `budget` and `spent` [s]. Empty with a solution.
        graph: Explored graph, on request and with a solution.
        is_spent: Whether it gave up after the allowed number of checked states.
        improves: Whether the planner optimises its path, which then is close to obstacles.
    """

    status: str
    waypoints: Float64[np.ndarray, "n nq"]
    goal_row: int
    growth: Mapping[str, Any]
    graph: PlannerGraph | None
    is_spent: bool
    improves: bool = False


def attempt(query: Query, edges: EdgeChecker, fine: EdgeChecker, seed: int) -> Attempt:
    """Run the planner once; the same seed gives the same path.

    OMPL's random numbers are global to the process: one search at a time.

    Args:
        query: Search problem.
        edges: Checker of the planner's motions.
        fine: Checker of the paths in the evidence of a failure.
        seed: Of OMPL's random numbers, 1 to 2^32 - 1.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    ou.RNG.setSeed(seed)
    information, planner, spent = _set_up(query, edges)
    if query.options.setup_time is not None and spent > query.options.setup_time:
        query.deadline.on_cut()
        return _not_begun(query, query.options.setup_time, spent)
    budget = query.deadline.within(query.options.solve_time)
    tell = query.on_better and partial(query.on_better, query.planner)
    states = query.most_states
    stopping = TerminationCondition(planner, query.oracle, budget, query.patience, states, tell)
    try:
        with query.watch.note("solve"), query.oracle.until(budget):
            status, found = _solve(planner, query, stopping)
        if found is None:
            query.deadline.check("search")
        elif isinstance(query.space, ProjectedSpace):
            with query.oracle.until(query.patience):
                found = query.space.threaded(information, found)
    except DeadlineExceeded as error:
        if query.deadline.is_over:
            raise error.saying(error.detail, _growth(planner, query, fine)) from error
        status, found = "Timeout", None
    finally:
        stopping.let_go()
    if found is None:
        growth = _growth(planner, query, fine)
        nothing = np.empty((0, len(query.start)))
        return Attempt(status, nothing, -1, growth, None, stopping.is_spent)
    return _report(query, fine, found, status, planner)


def _set_up(query: Query, edges: EdgeChecker) -> tuple[Any, Any, float]:
    """Return OMPL's space information, a planner after its setup, and the setup's duration [s].

    OMPL cannot be interrupted during the setup.
    """
    clock = query.deadline.clock
    began = clock()
    information = space_information(query.space, query.oracle, edges, query.planner)
    planner = make_planner(information, query.planner, query.parameters)
    planner.setProblemDefinition(_define(information, query))
    planner.setup()
    seconds = clock() - began
    query.watch.add("setup", seconds)
    return information, planner, query.space_seconds + seconds


def _not_begun(query: Query, budget: float, spent: float) -> Attempt:
    why = {"reason": "setup", "during": "setup", "budget": budget, "spent": spent}
    nothing = np.empty((0, len(query.start)))
    return Attempt("setup", nothing, -1, why, None, is_spent=False)


def _solve(planner: Any, query: Query, stopping: TerminationCondition) -> tuple[str, Array | None]:
    """Return OMPL's status string, and the waypoints if there is an exact solution."""
    if is_roadmap_planner(planner):
        costs = query.objective.edge_costs
        found = solve_by_roadmap(planner, query.space, stopping, len(query.goals), costs)
        return "Timeout" if found is None else "Exact solution", found
    status = planner.solve(ob.PlannerTerminationCondition(stopping)).asString()
    return status, _solution(planner.getProblemDefinition(), query.space)


def _define(information: Any, query: Query) -> Any:
    definition = ob.ProblemDefinition(information)
    definition.addStartState(query.space.write(query.start))
    goals = ob.GoalStates(information)
    for q in query.goals:
        goals.addState(query.space.write(q))
    definition.setGoal(goals)
    objective = query.objective.of_ompl(information, query.space, query.planner)
    if objective is not None:
        definition.setOptimizationObjective(objective)
    return definition


def _solution(definition: Any, space: SearchSpace) -> Array | None:
    """Return the waypoints of an exact solution; None for an approximate one."""
    if not definition.hasExactSolution():
        return None
    return np.array([space.read(state) for state in definition.getSolutionPath().getStates()])


def _report(query: Query, fine: EdgeChecker, found: Array, status: str, planner: Any) -> Attempt:
    distances = query.space.manifold.distance(query.goals, found[-1])
    row = int(np.argmin(distances))
    if distances[row] >= _SAME:
        nothing = np.empty((0, len(query.start)))
        return Attempt(status, nothing, -1, _growth(planner, query, fine), None, is_spent=False)
    path = np.concatenate([query.start[None], found[1:-1], query.goals[row][None]])
    waypoints = unrolled(path, query.space.manifold)
    if isinstance(query.space, CarSpace):
        waypoints = query.space.drives.threaded(waypoints)
    graph, improves = _kept_graph(planner, query, found), hasattr(planner, "bestCost")
    return Attempt(status, waypoints, row, {}, graph, is_spent=False, improves=improves)


def _kept_graph(planner: Any, query: Query, found: Array) -> PlannerGraph | None:
    if not (query.options.keep_graph and has_graph(planner)):
        return None
    graph = _graph(planner, query)
    return exported(query.planner, graph, query.space, found)


def _graph(planner: Any, query: Query) -> Graph:
    graph = read_graph(planner, planner.getSpaceInformation(), query.space)
    return between(graph, query.start, query.goals, query.space)


def _growth(planner: Any, query: Query, fine: EdgeChecker) -> dict[str, Any]:
    """Return the evidence of a failure: size of the explored graph and distance to the goals."""
    definition = planner.getProblemDefinition()
    is_near = definition.hasApproximateSolution()
    growth: dict[str, Any] = {
        "num_vertices": None,
        "num_edges": None,
        "goal_distance": definition.getSolutionDifference() if is_near else None,
    }
    if not has_graph(planner):
        return growth
    if not (query.options.approximate or query.options.keep_graph):
        graph = ob.PlannerData(planner.getSpaceInformation())
        planner.getPlannerData(graph)
        return growth | {"num_vertices": graph.numVertices(), "num_edges": graph.numEdges()}
    graph = _graph(planner, query)
    whole = exported(query.planner, graph, query.space, np.empty((0, len(query.start))))
    growth |= {"num_vertices": whole.num_vertices, "num_edges": whole.num_edges}
    if query.options.keep_graph:
        growth["graph"] = whole.plain
    if query.options.approximate:
        growth["approximate"] = approximate_solution(
            graph, query.space, query.goals, fine, query.oracle, query.deadline
        )
    return growth
