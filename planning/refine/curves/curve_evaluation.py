"""CurveEvaluation: what is known of one curve."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from planning.refine.constraints.distance_query import DistanceRows
from planning.refine.curves.path_velocity import NormalizedDerivatives
from planning.refine.model.load_evaluation import LoadEvaluation
from planning.refine.model.load_linearization import LoadLinearization

type Array = np.ndarray[Any, np.dtype[np.float64]]

# What a metre less than demanded costs at every instant and pair [s/m].
DISTANCE_PRICE = 20.0


@dataclass(frozen=True)
class CurveEvaluation:
    """What is known of one curve.

    Attributes:
        points: Its control points, shape (k, nq).
        rates: Its derivatives.
        pace: The fastest, b at the grid, shape (n + 1,).
        duration: Of that pace [s].
        near: Pairs that are near at the instants.
        wished: Pairs that are near enough for the wish, or None.
        worth: Duration and what falling short of the wish costs [s].
        felt: What loads do, if there are any.
        cost: The worth, and the price of distances that are too short and of torques that are too
            large without any motion [s].
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
        """Loads at that pace."""
        return () if self.felt is None else self.felt.strains(self.pace, self.duration)

    @cached_property
    def cost(self) -> float:
        """What is minimised [s]."""
        held = 0.0 if self.felt is None else self.felt.cost
        return self.worth + held + DISTANCE_PRICE * float(np.maximum(-self.near.spare, 0.0).sum())
