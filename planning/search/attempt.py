"""One solution by an OMPL planner, from a fresh start."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from planning.domain.deadline import Deadline
from planning.domain.value import Value
from planning.errors import DeadlineExceeded
from planning.search.edges import EdgeChecker
from planning.search.motions import space_information
from planning.search.oracle import WatchedOracle
from planning.search.parameters import Scalar
from planning.search.planners import make_planner
from planning.search.polyline import unrolled
from planning.search.projected import ProjectedSpace
from planning.search.roadmap import is_roadmap_planner, solve_by_roadmap
from planning.search.spaces import SearchSpace
from planning.search.stopping import Stopping
from planning.stopwatch import Stopwatch

type Array = np.ndarray[Any, np.dtype[np.float64]]

# A path that ends this near a goal ends there: the planner copies the goal's state.
_SAME = 1e-6


@dataclass(frozen=True)
class Query:
    """What every attempt needs.

    Attributes:
        space: Where to search.
        oracle: What is free.
        start: The group's q, shape (nq,).
        goals: Free configurations, shape (n, nq).
        planner: OMPL's name.
        parameters: Of the planner.
        deadline: When to give up.
        watch: Told how long shortcuts take.
    """

    space: SearchSpace
    oracle: WatchedOracle
    start: Float64[np.ndarray, " nq"]
    goals: Float64[np.ndarray, "n nq"]
    planner: str
    parameters: Mapping[str, Scalar]
    deadline: Deadline
    watch: Stopwatch


@dataclass(frozen=True, eq=False)
class Attempt(Value):
    """What a planner did.

    Attributes:
        status: OMPL's word for how it ended.
        waypoints: From the start to a goal, shape (n, nq); n = 0 if it found no exact solution.
        goal_row: Which goal, or -1.
        growth: Of its trees or roadmap `num_vertices` and `num_edges`, and `goal_distance`, the
            least distance to a goal in OMPL's metric; None where it does not tell. Nothing if it
            found a solution.
    """

    status: str
    waypoints: Float64[np.ndarray, "n nq"]
    goal_row: int
    growth: Mapping[str, int | float | None]


def attempt(query: Query, edges: EdgeChecker, seed: int) -> Attempt:
    """Let the planner look for a path; the same seed gives the same path.

    OMPL's random numbers are global to the process: one search at a time.

    Args:
        query: What to search.
        edges: How motions are checked.
        seed: Of OMPL's random numbers, 1 to 2^32 - 1.

    Raises:
        Canceled: Somebody asked for the end.
        DeadlineExceeded: The time has run out.
    """
    ou.RNG.setSeed(seed)
    information = space_information(query.space, query.oracle, edges, query.planner)
    planner = make_planner(information, query.planner, query.parameters)
    definition = _define(information, query)
    planner.setProblemDefinition(definition)
    planner.setup()
    stopping = Stopping(planner, query.oracle, query.deadline)
    try:
        status, found = _solve(planner, information, query, stopping)
        if found is None:
            query.deadline.check("search")
        elif isinstance(query.space, ProjectedSpace):
            found = query.space.threaded(information, found)
    except DeadlineExceeded as error:
        raise DeadlineExceeded(error.detail, error.evidence | _growth(planner)) from error
    finally:
        stopping.let_go()
    return _report(query, found, status, planner)


def _solve(
    planner: Any, information: Any, query: Query, stopping: Stopping
) -> tuple[str, Array | None]:
    """Return OMPL's word for how it ended, and the waypoints if there is an exact solution."""
    if is_roadmap_planner(planner):
        found = solve_by_roadmap(planner, information, query.space, stopping, len(query.goals))
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
    if query.space.is_mixed:
        definition.setOptimizationObjective(_length(information))
    return definition


def _length(information: Any) -> Any:
    """Return the length of a path as an objective that planners can use in a compound space.

    For OMPL's own they sample where a path could still get shorter, and that sampler refuses
    compounds; wrapped, it lets them sample everywhere and reject.
    """
    length = ob.MultiOptimizationObjective(information)
    length.addObjective(ob.PathLengthOptimizationObjective(information), 1.0)
    length.lock()
    return length


def _solution(definition: Any, space: SearchSpace) -> Array | None:
    """Return the waypoints if there is an exact solution; an approximate one is none."""
    if not definition.hasExactSolution():
        return None
    return np.array([space.read(state) for state in definition.getSolutionPath().getStates()])


def _report(query: Query, found: Array | None, status: str, planner: Any) -> Attempt:
    goal_row = -1
    waypoints = np.empty((0, len(query.start)))
    if found is not None:
        distances = query.space.manifold.distance(query.goals, found[-1])
        row = int(np.argmin(distances))
        if distances[row] < _SAME:
            goal_row = row
            ends = query.start[None], query.goals[row][None]
            path = np.concatenate([ends[0], found[1:-1], ends[1]])
            waypoints = unrolled(path, query.space.manifold)
    return Attempt(status, waypoints, goal_row, {} if goal_row >= 0 else _growth(planner))


def _growth(planner: Any) -> dict[str, int | float | None]:
    """Return how far the planner got."""
    definition = planner.getProblemDefinition()
    is_near = definition.hasApproximateSolution()
    growth = {
        "num_vertices": None,
        "num_edges": None,
        "goal_distance": definition.getSolutionDifference() if is_near else None,
    }
    # Asked for its graph, BITstar keeps the whole space information in memory for ever (2.0.1).
    if not isinstance(planner, og.BITstar):
        graph = ob.PlannerData(planner.getSpaceInformation())
        planner.getPlannerData(graph)
        growth |= {"num_vertices": graph.numVertices(), "num_edges": graph.numEdges()}
    return growth
