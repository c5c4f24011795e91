"""CurveEvaluation: cost, path velocity, distances and loads of one curve."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planning.domain.arrays import Array
from planning.refine.constraints.distance_query import DistanceRows
from planning.refine.model.load_evaluation import LoadEvaluation
from planning.refine.model.load_linearization import LoadLinearization

# Penalty of a metre less than the required distance, per instant and pair [s/m].
DISTANCE_PENALTY = 20.0


@dataclass(frozen=True)
class CurveEvaluation:
    """Cost terms and linearization data of one curve.

    Attributes:
        points: Its control points, shape (k, nq).
        path_velocity: Minimum-time squared path velocity b [1/s^2] at the grid, shape (n + 1,).
        duration: Duration at that path velocity [s].
        distances: Distances of near pairs at the instants.
        num_instants: Number of the instants.
        clearances: Distances of pairs within reach of the clearance objective, or None.
        objective: Duration plus cost of the clearance objective [s].
        loads: Load evaluation, or None without loads.
    """

    points: Array
    path_velocity: Array
    duration: float
    distances: DistanceRows
    num_instants: int
    clearances: DistanceRows | None
    objective: float
    loads: LoadEvaluation | None

    @cached_property
    def load_linearizations(self) -> tuple[LoadLinearization, ...]:
        """Load linearizations at `path_velocity`."""
        return (
            ()
            if self.loads is None
            else self.loads.load_linearizations(self.path_velocity, self.duration)
        )

    @property
    def merit_scale(self) -> float:
        """Scale of the merit: the duration [s]."""
        return self.duration

    @property
    def merit(self) -> float:
        """Merit, which the optimization minimizes [s].

        It is `objective` plus the penalties of short distances and of excessive static loads.
        """
        static_load_penalty = 0.0 if self.loads is None else self.loads.penalty
        return self.objective + static_load_penalty + self._distance_penalty

    @cached_property
    def _distance_penalty(self) -> float:
        return distance_penalty(self.distances)


def distance_penalty(distances: DistanceRows) -> float:
    """Return the penalty of distances that are too short [s]."""
    return DISTANCE_PENALTY * float(np.maximum(-distances.signed_margins, 0.0).sum())
