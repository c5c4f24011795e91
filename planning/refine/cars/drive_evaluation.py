"""DriveEvaluation: cost, duration and distances of one car path."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.refine.cars.arc_segments import ArcSegments, PathSamples, SegmentPoses
from planning.refine.constraints.distance_query import DistanceRows
from planning.refine.curves.curve_evaluation import DISTANCE_PRICE


@dataclass(frozen=True)
class DriveEvaluation:
    """Cost terms and linearization data of one car path that ends at the goal.

    Attributes:
        letters: Arc segments of the path.
        spots: Samples of the path; the last one is the end.
        places: Poses at the samples.
        near: Distances of near pairs, at all samples but the end.
        wished: Distances of pairs within reach of the clearance objective, or None.
        duration: Of the path [s].
        worth: Duration plus cost of the clearance objective [s].
        outside: Violation of the limits of x and y, summed over the samples [m].
    """

    letters: ArcSegments
    spots: PathSamples
    places: SegmentPoses
    near: DistanceRows
    wished: DistanceRows | None
    duration: float
    worth: float
    outside: float

    @cached_property
    def cost(self) -> float:
        """Merit: `worth` plus the penalty of distances that are too short and of `outside` [s]."""
        lacking = float(np.maximum(-self.near.spare, 0.0).sum()) + self.outside
        return self.worth + DISTANCE_PRICE * lacking

    def carried(self, at: Any, gradient: Array, car: int, others: list[int]) -> Array:
        """Return derivatives by all variables from gradients by v (chain rule), shape (m, v).

        Args:
            at: Indices of the samples.
            gradient: Gradients by v at these samples, shape (m, nv).
            car: Index of the car's first coordinate in v.
            others: Indices of the other joints' coordinates in v.
        """
        n, k = len(self.letters), len(others)
        by_car = np.einsum("mi,mij->mj", gradient[:, car : car + 3], self.places.slopes[at])
        if not k or n == 1:
            return by_car
        by_other = np.zeros((len(at), n + 1, k))
        rows, owners = np.arange(len(at)), self.spots.owners[at]
        share = self.spots.fractions[at][:, None]
        by_other[rows, owners] = (1 - share) * gradient[:, others]
        by_other[rows, owners + 1] += share * gradient[:, others]
        return np.concatenate([by_car, by_other[:, 1:-1].reshape(len(at), -1)], axis=1)
