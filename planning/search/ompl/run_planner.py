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
from planning.search.ompl.graph import (
    Graph,
    export_graph,
    has_graph,
    read_graph,
    with_query_vertices,
)
from planning.search.ompl.native_trees import (
    Trees,
    failure_evidence,
    grow,
    native_trees,
)
from planning.search.ompl.path_so_far import path_so_far
from planning.search.ompl.planner_list import make_planner
from planning.search.ompl.prm import is_roadmap_planner, solve_by_roadmap
from planning.search.ompl.projected_space import ProjectedSpace
from planning.search.ompl.spaces import SearchSpace
from planning.search.ompl.termination import TerminationCondition
from planning.search.ompl.validity import space_information
from planning.search.query import Query
from planning.search.shortcut.polyline import unwrap

# Largest distance of a path's end from a goal: the planner copies the goal's state.
_GOAL_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Attempt(Value):
    """Result of one run of a planner.

    Attributes:
        status: OMPL's status string; "setup" if the setup took all of its time.
        waypoints: From the start to a goal, shape (n, nq); n = 0 without an exact solution.
        goal_row: Row of that goal, or -1.
        failure_evidence: Evidence of a failure: `num_vertices` and `num_edges` of its trees or
            roadmap, and `goal_distance`, the least distance to a goal in OMPL's metric, None where
            the planner has no such value. `approximate` and `graph` on request. After a setup that
            took too long: `reason`, `during`, `budget` and `spent` [s]. Empty with a solution.
        graph: Explored graph, on request and with a solution.
        has_given_up: Whether it gave up after the allowed number of checked states.
        is_optimizing: Whether the planner optimizes its path, which then is close to obstacles.
    """

    status: str
    waypoints: Float64[np.ndarray, "n nq"]
    goal_row: int
    failure_evidence: Mapping[str, Any]
    graph: PlannerGraph | None
    has_given_up: bool
    is_optimizing: bool = False


def run_planner(query: Query, edges: EdgeChecker, fine: EdgeChecker, seed: int) -> Attempt:
    """Run the planner once; the same seed gives the same path.

    OMPL's random numbers are global to the process: one search at a time.

    Args:
        query: Search problem.
        edges: Checker of the planner's motions.
        fine: Checker of the paths in the evidence of a failure.
        seed: Seed of OMPL's random numbers, 1 to 2^32 - 1.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    trees = native_trees(query, edges, seed)
    if trees is not None:
        return _run_natively(trees, query, edges)
    information, planner, setup_seconds = _set_up(query, edges, seed)
    if query.options.setup_time is not None and setup_seconds > query.options.setup_time:
        query.deadline.on_expiry()
        return _setup_timeout(query, query.options.setup_time, setup_seconds)
    budget = query.deadline.within(query.options.solve_time)
    on_improvement = query.on_improvement and partial(_tell_path, query, planner)
    max_checked_states = query.max_checked_states
    termination = TerminationCondition(
        planner, query.oracle, budget, query.completion_deadline, max_checked_states, on_improvement
    )
    try:
        with query.watch.measure("solve"), query.oracle.with_deadline(budget):
            status, waypoints = _solve(planner, query, termination)
        if waypoints is None:
            query.deadline.check("search")
        elif isinstance(query.space, ProjectedSpace):
            with query.oracle.with_deadline(query.completion_deadline):
                waypoints = query.space.interpolate(information, waypoints)
    except DeadlineExceeded as error:
        if query.deadline.is_over:
            raise error.saying(error.detail, _failure_evidence(planner, query, fine)) from error
        status, waypoints = "Timeout", None
    finally:
        termination.release_planner()
    if waypoints is None:
        evidence = _failure_evidence(planner, query, fine)
        no_waypoints = np.empty((0, len(query.start)))
        return Attempt(status, no_waypoints, -1, evidence, None, termination.has_given_up)
    return _report(query, fine, waypoints, status, planner)


def _run_natively(trees: Trees, query: Query, edges: EdgeChecker) -> Attempt:
    """Do the same by the oracle's own trees, with the same result."""
    budget = query.deadline.within(query.options.solve_time)
    has_given_up, waypoints = False, None
    try:
        with query.watch.measure("solve"), query.oracle.with_deadline(budget):
            waypoints = grow(trees, query, edges)
        if waypoints is None:
            has_given_up = True
            query.deadline.check("search")
    except DeadlineExceeded as error:
        if query.deadline.is_over:
            raise error.saying(error.detail, failure_evidence(trees)) from error
    path = None if waypoints is None else _path_to_goal(query, waypoints)
    if path is not None:
        return Attempt("Exact solution", *path, {}, None, has_given_up=False)
    evidence = failure_evidence(trees)
    status = "Timeout" if evidence["goal_distance"] is None else "Approximate solution"
    no_waypoints = np.empty((0, len(query.start)))
    return Attempt(status, no_waypoints, -1, evidence, None, has_given_up)


def _tell_path(query: Query, planner: Any, cost: float) -> None:
    """Report the path that the planner has now."""
    if query.on_improvement is not None:
        waypoints = path_so_far(planner, query.space)
        if len(waypoints):
            waypoints = _in_planning_coordinates(query, waypoints)
        query.on_improvement(query.planner, cost, waypoints)


def _set_up(query: Query, edges: EdgeChecker, seed: int) -> tuple[Any, Any, float]:
    """Return OMPL's space information, a planner after its setup, and the setup's duration [s].

    OMPL cannot be interrupted during the setup.
    """
    clock = query.deadline.clock
    began = clock()
    _ = query.space.ompl  # it has random numbers of its own, which are not to follow the seed
    ou.RNG.setSeed(seed)
    information = space_information(query.space, query.oracle, edges, query.planner)
    planner = make_planner(information, query.planner, query.parameters)
    planner.setProblemDefinition(_problem_definition(information, query))
    planner.setup()
    seconds = clock() - began
    query.watch.add("setup", seconds)
    return information, planner, query.space_seconds + seconds


def _setup_timeout(query: Query, budget: float, setup_seconds: float) -> Attempt:
    evidence = {"reason": "setup", "during": "setup", "budget": budget, "spent": setup_seconds}
    no_waypoints = np.empty((0, len(query.start)))
    return Attempt("setup", no_waypoints, -1, evidence, None, has_given_up=False)


def _solve(
    planner: Any, query: Query, termination: TerminationCondition
) -> tuple[str, Array | None]:
    """Return OMPL's status string, and the waypoints if there is an exact solution."""
    if is_roadmap_planner(planner):
        costs = query.objective.edge_costs
        waypoints = solve_by_roadmap(planner, query.space, termination, len(query.goals), costs)
        return "Timeout" if waypoints is None else "Exact solution", waypoints
    status = planner.solve(ob.PlannerTerminationCondition(termination)).asString()
    return status, _solution(planner.getProblemDefinition(), query.space)


def _problem_definition(information: Any, query: Query) -> Any:
    definition = ob.ProblemDefinition(information)
    definition.addStartState(query.space.write(query.start))
    goals = ob.GoalStates(information)
    for q in query.goals:
        goals.addState(query.space.write(q))
    definition.setGoal(goals)
    objective = query.objective.make_ompl_objective(information, query.space, query.planner)
    if objective is not None:
        definition.setOptimizationObjective(objective)
    return definition


def _solution(definition: Any, space: SearchSpace) -> Array | None:
    """Return the waypoints of an exact solution; None for an approximate one."""
    if not definition.hasExactSolution():
        return None
    return np.array([space.read(state) for state in definition.getSolutionPath().getStates()])


def _report(query: Query, fine: EdgeChecker, solution: Array, status: str, planner: Any) -> Attempt:
    path = _path_to_goal(query, solution)
    if path is None:
        evidence = _failure_evidence(planner, query, fine)
        no_waypoints = np.empty((0, len(query.start)))
        return Attempt(status, no_waypoints, -1, evidence, None, has_given_up=False)
    waypoints, row = path
    graph, is_optimizing = _graph_on_request(planner, query, solution), hasattr(planner, "bestCost")
    return Attempt(
        status, waypoints, row, {}, graph, has_given_up=False, is_optimizing=is_optimizing
    )


def _path_to_goal(query: Query, solution: Array) -> tuple[Array, int] | None:
    """Return a path from the given start to the nearest goal, and its row; None if it is far."""
    distances = query.space.manifold.distance(query.goals, solution[-1])
    row = int(np.argmin(distances))
    if distances[row] >= _GOAL_TOLERANCE:
        return None
    path = np.concatenate([query.start[None], solution[1:-1], query.goals[row][None]])
    return _in_planning_coordinates(query, path), row


def _in_planning_coordinates(query: Query, path: Array) -> Array:
    """Return a planner's path without jumps, a car's with the ends of its arcs."""
    waypoints = unwrap(path, query.space.manifold)
    if isinstance(query.space, CarSpace):
        waypoints = query.space.steering_paths.waypoints_through(waypoints)
    return waypoints


def _graph_on_request(planner: Any, query: Query, solution: Array) -> PlannerGraph | None:
    if not (query.options.keep_graph and has_graph(planner)):
        return None
    graph = _graph(planner, query)
    return export_graph(query.planner, graph, query.space, solution)


def _graph(planner: Any, query: Query) -> Graph:
    graph = read_graph(planner, planner.getSpaceInformation(), query.space)
    return with_query_vertices(graph, query.start, query.goals, query.space)


def _failure_evidence(planner: Any, query: Query, fine: EdgeChecker) -> dict[str, Any]:
    """Return the evidence of a failure: size of the explored graph and distance to the goals."""
    definition = planner.getProblemDefinition()
    has_approximation = definition.hasApproximateSolution()
    evidence: dict[str, Any] = {
        "num_vertices": None,
        "num_edges": None,
        "goal_distance": definition.getSolutionDifference() if has_approximation else None,
    }
    if not has_graph(planner):
        return evidence
    if not (query.options.approximate or query.options.keep_graph):
        graph = ob.PlannerData(planner.getSpaceInformation())
        planner.getPlannerData(graph)
        return evidence | {"num_vertices": graph.numVertices(), "num_edges": graph.numEdges()}
    graph = _graph(planner, query)
    planner_graph = export_graph(query.planner, graph, query.space, np.empty((0, len(query.start))))
    evidence |= {"num_vertices": planner_graph.num_vertices, "num_edges": planner_graph.num_edges}
    if query.options.keep_graph:
        evidence["graph"] = planner_graph.as_json
    if query.options.approximate:
        evidence["approximate"] = approximate_solution(
            graph, query.space, query.goals, fine, query.oracle, query.deadline
        )
    return evidence
