"""CurveEvaluation: cost, path velocity, distances and loads of one curve."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planning.domain.arrays import Array
from planning.refine.constraints.distance_query import DistanceRows
from planning.refine.curves.path_velocity import NormalizedDerivatives
from planning.refine.model.load_evaluation import LoadEvaluation
from planning.refine.model.load_linearization import LoadLinearization

# Penalty of a metre less than the required distance, per instant and pair [s/m].
DISTANCE_PRICE = 20.0


@dataclass(frozen=True)
class CurveEvaluation:
    """Cost terms and linearization data of one curve.

    Attributes:
        points: Its control points, shape (k, nq).
        rates: Its derivatives over the rate bounds.
        pace: Minimum-time squared path velocity b [1/s^2] at the grid, shape (n + 1,).
        duration: At that path velocity [s].
        near: Distances of near pairs at the instants.
        wished: Distances of pairs within reach of the clearance objective, or None.
        worth: Duration plus cost of the clearance objective [s].
        felt: Load evaluation, or None without loads.
        cost: Merit: `worth` plus the penalties of distances that are too short and of static loads
            that are too large [s].
    """

    points: Array
    rates: NormalizedDerivatives
    pace: Array
    duration: float
    near: DistanceRows
    wished: DistanceRows | None
    worth: float
    felt: LoadEvaluation | None

    @cached_property
    def strains(self) -> tuple[LoadLinearization, ...]:
        """Load linearizations at that path velocity."""
        return () if self.felt is None else self.felt.strains(self.pace, self.duration)

    @cached_property
    def cost(self) -> float:
        """Merit of the curve, which the optimisation minimises [s]."""
        held = 0.0 if self.felt is None else self.felt.cost
        return self.worth + held + DISTANCE_PRICE * float(np.maximum(-self.near.spare, 0.0).sum())
