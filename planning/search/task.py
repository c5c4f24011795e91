"""What the search stage is asked, and what it answers."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.options import SearchOptions
from planning.domain.path import JointPath
from planning.domain.report import SearchReport
from planning.domain.value import Value
from planning.search.projected import Residual


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
        residual: What vanishes on a set that is too thin to be sampled, or None.
    """

    start: Float64[np.ndarray, " nq"]
    goals: Float64[np.ndarray, "n nq"]
    options: SearchOptions
    resolution: float
    padding: float
    seed: int
    residual: Residual | None = None


@dataclass(frozen=True, eq=False)
class SearchResult(Value):
    """What the stage found.

    Attributes:
        path: From exactly the start to exactly one of the goals.
        goal_row: Which goal.
        report: What was done.
    """

    path: JointPath
    goal_row: int
    report: SearchReport
