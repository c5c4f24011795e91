"""JointFeasibility: which of some configurations is the first that is allowed."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.goals.goal_query import GoalQuery
from planning.goals.start import within_limits
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Configurations that are judged at once.
_AT_ONCE = 64


class JointFeasibility:
    """Judges configurations in order, and no more of them than it takes."""

    def __init__(self, world: World, query: GoalQuery) -> None:
        """Judge by the world's limits, its bodies, and the query's rules."""
        self._limits = world.limits(query.group)
        self._oracle = world.collision_oracle(query.group, query.margins)
        self._rules = query.rules

    def first(self, rows: Float64[np.ndarray, "n nq"]) -> int | None:
        """Return the index of the first row that is feasible, None if none is."""
        for begin in range(0, len(rows), _AT_ONCE):
            some = rows[begin : begin + _AT_ONCE]
            feasible = within_limits(self._limits, some)
            feasible[feasible] = self._oracle.are_free(some[feasible])
            if self._rules is not None:
                feasible[feasible] = self._rules.are_kept(some[feasible])
            kept = np.flatnonzero(feasible)
            if len(kept):
                return begin + int(kept[0])
        return None
