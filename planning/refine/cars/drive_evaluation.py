"""DriveEvaluation: what is known of one drive."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from planning.refine.cars.arc_segments import ArcSegments, PathSamples, SegmentPoses
from planning.refine.constraints.distance_query import DistanceRows
from planning.refine.curves.curve_evaluation import DISTANCE_PRICE

type Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class DriveEvaluation:
    """What is known of one drive that ends at the goal, from places on it.

    Attributes:
        letters: The drive.
        spots: The places; the last one is the end.
        places: Where they are.
        near: Pairs that are near, at all of them but the end.
        wished: Pairs that are near enough for the wish, or None.
        duration: Of the drive [s].
        worth: Duration and what falling short of the wish costs [s].
        outside: By how far places are outside the limits of x and y, in sum [m].
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
        """The worth, and the price of distances that are too short [s]."""
        lacking = float(np.maximum(-self.near.spare, 0.0).sum()) + self.outside
        return self.worth + DISTANCE_PRICE * lacking

    def carried(self, at: Any, gradient: Array, car: int, others: list[int]) -> Array:
        """Return derivatives by all variables of what has gradients by v, shape (m, v).

        Args:
            at: At which places.
            gradient: Shape (m, nv).
            car: Where the car's coordinates begin in v.
            others: Those of the other joints.
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
