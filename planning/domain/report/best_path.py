"""BestPath: the best path of a search that still goes on, for those who look on."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.report.search_report import AttemptReport
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class BestPath(Value):
    """A path that is better than those before it.

    What a planner is still improving is free at its own resolution only. Nothing is proven of it.

    Attributes:
        attempt: The attempt that found it, or is at work on it.
        waypoints: From the start to a goal, shape (n, nq); n = 0 where the planner tells no more
            than the length.
    """

    attempt: AttemptReport
    waypoints: Float64[np.ndarray, "n nq"]
