"""Feasibility: batch check of configurations for limits, collisions and path constraints."""

import numpy as np
from jaxtyping import Bool, Float64

from planning.goals.goal_query import GoalQuery
from planning.goals.start_validation import within_limits
from planning.world.world import World

# Configurations per batch.
_BATCH_SIZE = 64


class Feasibility:
    """Check of configurations against joint limits, collisions and the query's path constraints.

    The goal itself is not checked.
    """

    def __init__(self, world: World, query: GoalQuery) -> None:
        """Prepare for the query's group, margins and path constraints."""
        self._limits = world.limits(query.group)
        self._oracle = world.collision_oracle(query.group, query.margins)
        self._constraints = query.constraints

    def are_feasible(self, rows: Float64[np.ndarray, "n nq"]) -> Bool[np.ndarray, " n"]:
        """Return which rows are within limits, collision-free and satisfy the path constraints."""
        feasible = within_limits(self._limits, rows)
        feasible[feasible] = self._oracle.are_free(rows[feasible])
        if self._constraints is not None:
            feasible[feasible] = self._constraints.are_satisfied(rows[feasible])
        return feasible

    def first_feasible(self, rows: Float64[np.ndarray, "n nq"]) -> int | None:
        """Return the index of the first feasible row; None if none is.

        Rows are checked in batches, up to the batch of the result.
        """
        for begin in range(0, len(rows), _BATCH_SIZE):
            feasible = np.flatnonzero(self.are_feasible(rows[begin : begin + _BATCH_SIZE]))
            if len(feasible):
                return begin + int(feasible[0])
        return None
