"""Query: one search problem as every attempt gets it: space, oracle, start, goals, budgets."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import SearchOptions
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.robot.steering import steering_of
from planning.domain.robot.steering_request import validate_forward_planners
from planning.errors import NoPathFound
from planning.search.collision_oracle import CollisionOracle, WatchedOracle
from planning.search.ompl.car_space import CarSpace
from planning.search.ompl.objective import Objective
from planning.search.ompl.parameters import Scalar
from planning.search.ompl.planner_list import check_planners
from planning.search.ompl.projected_space import ProjectedSpace
from planning.search.ompl.spaces import SearchSpace
from planning.search.request import SearchTask
from planning.search.space_options import bounded_limits, held_rotations, metric_weights


@dataclass(frozen=True)
class Query:
    """Search problem, shared by all attempts.

    Attributes:
        space: State space of the search.
        oracle: Collision oracle.
        start: The group's q, shape (nq,).
        goals: Free configurations, shape (n, nq).
        planner: OMPL's name of the planner.
        parameters: Parameters of the planner.
        deadline: End of the search.
        watch: Records the durations of the stages of a search.
        objective: Cost of a path, to be minimized.
        options: The other options of the request.
        space_seconds: Duration of the construction of the space [s].
        max_checked_states: Checked states after which a planner without a solution gives up.
        on_improvement: Callback with the planner's name, its best cost, and its path, shape
            (n, nq), n = 0 where it shows none; at intervals while it improves.
    """

    space: SearchSpace
    oracle: WatchedOracle
    start: Float64[np.ndarray, " nq"]
    goals: Float64[np.ndarray, "n nq"]
    planner: str
    parameters: Mapping[str, Scalar]
    deadline: Deadline
    watch: Stopwatch
    objective: Objective
    options: SearchOptions
    space_seconds: float = 0.0
    max_checked_states: float = math.inf
    on_improvement: Callable[[str, float, Array], None] | None = None

    @property
    def is_canceled_keeping_best(self) -> bool:
        """Whether the request was canceled with the option to return the best path so far."""
        return self.options.on_cancel == "best" and self.deadline.is_canceled()

    @property
    def completion_deadline(self) -> Deadline:
        """Deadline for finishing a path: a cancel that wants the best path does not end it."""
        keeps_best = self.options.on_cancel == "best"
        return self.deadline.uncancelable if keeps_best else self.deadline


def make_query(
    group: JointGroup,
    limits: JointLimits,
    oracle: CollisionOracle,
    task: SearchTask,
    deadline: Deadline,
    watch: Stopwatch | None,
) -> tuple[Query, np.ndarray[Any, np.dtype[np.intp]]]:
    """Return the search problem of a task, and the rows of the admissible goals."""
    options = task.options
    check_planners(options.planners, options.parameters)
    validate_forward_planners(options.planners, steering_of(group))
    limits = bounded_limits(group, limits, options.bounds)
    weights = metric_weights(group, options.weights)
    watched = WatchedOracle(oracle, group, limits, deadline)
    watch = watch or Stopwatch(deadline.clock)
    began = deadline.clock()
    space = _make_space(group, limits, task, weights)
    space_seconds = deadline.clock() - began
    watch.add("setup", space_seconds)
    rows = _admissible_goals(space, watched, task)
    query = Query(
        space=space,
        oracle=watched,
        start=task.start,
        goals=task.goals[rows],
        planner=options.planners[0],
        parameters=options.parameters,
        deadline=deadline,
        watch=watch,
        objective=Objective(options.objective, group, limits, weights, task.clearances),
        options=options,
        space_seconds=space_seconds,
    )
    return query, rows


def _make_space(
    group: JointGroup, limits: JointLimits, task: SearchTask, weights: Array
) -> SearchSpace:
    anchors = np.concatenate([task.start[None], task.goals])
    spaces = task.options.spaces
    held_indices = held_rotations(group, spaces) if spaces else []
    if task.residual is not None:
        return ProjectedSpace(group, limits, anchors, task.residual)
    if steering_of(group):
        return CarSpace(group, limits, anchors, weights)
    return SearchSpace(group, limits, anchors, weights, held_indices)


def can_project(group: JointGroup, options: SearchOptions) -> bool:
    """Return whether a search with these options can project samples onto a constraint set."""
    return not (options.weights or options.spaces or steering_of(group))


def _admissible_goals(
    space: SearchSpace, oracle: WatchedOracle, task: SearchTask
) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Return the rows of the goals that are inside the space and free.

    Raises:
        NoPathFound: There is none, or the start itself is inadmissible.
    """
    if not (space.contains(task.start[None])[0] and oracle.is_free(task.start)):
        message = "the start violates the position limits, search.bounds or the required clearance"
        raise NoPathFound(message, _evidence(task) | {"reason": "start"})
    rows = np.flatnonzero(space.contains(task.goals))
    rows = rows[oracle.are_free(task.goals[rows])] if len(rows) else rows
    if not len(rows):
        message = (
            "every goal violates the position limits, search.bounds, a rotation that search.spaces "
            "holds, or the required clearance"
        )
        evidence = {"reason": "goals", "num_goals": len(task.goals)}
        raise NoPathFound(message, _evidence(task) | evidence)
    return rows


def _evidence(task: SearchTask) -> dict[str, Any]:
    return {"planner": ", ".join(task.options.planners), "padding": task.padding}
