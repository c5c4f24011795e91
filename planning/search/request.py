"""SearchTask and SearchResult: input and output of the search stage."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from planning.domain.curves.path import JointPath
from planning.domain.planner.planner_graph import PlannerGraph
from planning.domain.planner.roadmap import Roadmap
from planning.domain.report.best_path import BestPath
from planning.domain.report.search_report import SearchReport
from planning.domain.request.attempt_pool import AttemptPool
from planning.domain.request.options import SearchOptions
from planning.domain.value import Value
from planning.search.ompl.projected_space import Residual

type Clearances = Callable[
    [np.ndarray[Any, np.dtype[np.float64]]], np.ndarray[Any, np.dtype[np.float64]]
]


@runtime_checkable
class PathGuide(Protocol):
    """Source of a candidate path other than a planner, for example regions.

    Attributes:
        name: Name in reports, in place of the planner's.
    """

    name: str

    def propose_path(
        self, goals: Float64[np.ndarray, "n nq"]
    ) -> tuple[Float64[np.ndarray, "m nq"], int] | None:
        """Return a path from the start to one of the goals, and that goal's row, or None."""
        ...


@dataclass(frozen=True, eq=False)
class SearchTask(Value):
    """Input of the search stage.

    Attributes:
        start: The group's q, shape (nq,).
        goals: Goal configurations, nearest first, shape (n, nq).
        options: Planner, parameters, attempts, number of states.
        resolution: Largest distance between two checked states while searching; used in place of
            the one of the options, which the pipeline makes finer in later rounds.
        padding: Distance that the oracle requires beyond the margin [m]; for the report.
        seed: Seed of all random numbers, not negative.
        residual: Constraint residual, on whose zero set samples are projected, or None.
        max_checked_states: States that an attempt may check until it has a solution. If all
            attempts have checked as many, the search gives up, and the failure's evidence has
            `num_given_up`.
        clearances: Returns for rows of q the distances to everything but the robot [m]; for the
            objective "clearance".
        on_best: Callback with every path that is the best so far, and at intervals with the ones
            that a planner is still improving.
        guide: Source of a path that is used before the planner, if there is no straight line.
        roadmap: Roadmap that is queried before any planner, or None.
        pool: Pool of processes for concurrent attempts, or None.
    """

    start: Float64[np.ndarray, " nq"]
    goals: Float64[np.ndarray, "n nq"]
    options: SearchOptions
    resolution: float
    padding: float
    seed: int
    residual: Residual | None = None
    max_checked_states: float = math.inf
    clearances: Clearances | None = None
    on_best: Callable[[BestPath], None] | None = None
    guide: PathGuide | None = None
    roadmap: Roadmap | None = None
    pool: AttemptPool | None = None


@dataclass(frozen=True, eq=False)
class SearchResult(Value):
    """Output of the search stage.

    Attributes:
        path: From exactly the start to exactly one of the goals.
        goal_row: Row of that goal.
        report: Statistics of the search.
        graph: Graph that the planner explored, if it was requested and the planner has one.
    """

    path: JointPath
    goal_row: int
    report: SearchReport
    graph: PlannerGraph | None = None
