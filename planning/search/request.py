"""What the search stage is asked, and what it answers."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from planning.domain.curves.path import JointPath
from planning.domain.planner.planner_graph import PlannerGraph
from planning.domain.planner.roadmap import Roadmap
from planning.domain.report.search_report import AttemptReport, SearchReport
from planning.domain.request.attempt_pool import AttemptPool
from planning.domain.request.options import SearchOptions
from planning.domain.value import Value
from planning.search.ompl.projected_space import Residual

type Clearances = Callable[
    [np.ndarray[Any, np.dtype[np.float64]]], np.ndarray[Any, np.dtype[np.float64]]
]


@runtime_checkable
class PathGuide(Protocol):
    """Somebody who may know a path.

    Attributes:
        name: Stands for the planner's in reports.
    """

    name: str

    def lead(
        self, goals: Float64[np.ndarray, "n nq"]
    ) -> tuple[Float64[np.ndarray, "m nq"], int] | None:
        """Return a path from the start to one of the goals, and the goal's row, if there is one."""
        ...


@dataclass(frozen=True, eq=False)
class SearchTask(Value):
    """What the stage is asked.

    Attributes:
        start: The group's q, shape (nq,).
        goals: Where it may end, nearest first, shape (n, nq).
        options: Planner, parameters, attempts, number of states.
        resolution: Largest distance between two checked states while searching; it stands for
            that of the options, which the pipeline makes finer in later rounds.
        padding: Distance that the oracle demands beyond the margin [m]; for the report.
        seed: Of all randomness, not negative.
        residual: What vanishes on a set that samples are to be projected onto, or None.
        most_states: How many states an attempt may check until it has a solution. If all attempts
            have, the search gives up, and the failure's evidence has `num_given_up`.
        clearances: Returns for rows of q the distances to what is not the robot [m]; for the
            objective "clearance".
        on_best: Told of every path that is the best so far; of those that a planner is still
            improving now and then.
        guide: Asked for a path before the planner is, if there is no straight line.
        roadmap: Where a way is looked for before any planner is asked, or None.
        pool: Makes attempts at once, or None.
    """

    start: Float64[np.ndarray, " nq"]
    goals: Float64[np.ndarray, "n nq"]
    options: SearchOptions
    resolution: float
    padding: float
    seed: int
    residual: Residual | None = None
    most_states: float = math.inf
    clearances: Clearances | None = None
    on_best: Callable[[AttemptReport], None] | None = None
    guide: PathGuide | None = None
    roadmap: Roadmap | None = None
    pool: AttemptPool | None = None


@dataclass(frozen=True, eq=False)
class SearchResult(Value):
    """What the stage found.

    Attributes:
        path: From exactly the start to exactly one of the goals.
        goal_row: Which goal.
        report: What was done.
        graph: What the planner explored, if that was asked for and it tells.
    """

    path: JointPath
    goal_row: int
    report: SearchReport
    graph: PlannerGraph | None = None
