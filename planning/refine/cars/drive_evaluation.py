"""DriveEvaluation: cost, duration and distances of one car path."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.refine.cars.arc_segments import ArcSegments, PathSamples, SegmentPoses
from planning.refine.constraints.distance_query import DistanceRows
from planning.refine.curves.curve_evaluation import DISTANCE_PENALTY


@dataclass(frozen=True)
class DriveEvaluation:
    """Cost terms and linearization data of one car path that ends at the goal.

    Attributes:
        segments: Arc segments of the path.
        samples: Samples of the path; the last one is the end.
        segment_poses: Poses at the samples.
        distances: Distances of near pairs, at all samples but the end.
        clearances: Distances of pairs within reach of the clearance objective, or None.
        duration: Duration of the path [s].
        objective: Duration plus cost of the clearance objective [s].
        limit_violation: Violation of the limits of x and y, summed over the samples [m].
    """

    segments: ArcSegments
    samples: PathSamples
    segment_poses: SegmentPoses
    distances: DistanceRows
    clearances: DistanceRows | None
    duration: float
    objective: float
    limit_violation: float

    @cached_property
    def merit(self) -> float:
        """Merit [s]: `objective` plus penalties of short distances and of `limit_violation`."""
        violation = (
            float(np.maximum(-self.distances.signed_margins, 0.0).sum()) + self.limit_violation
        )
        return self.objective + DISTANCE_PENALTY * violation

    def derivatives_by_variables(
        self, sample_indices: Any, gradient: Array, car: int, other_indices: list[int]
    ) -> Array:
        """Return derivatives by all variables from gradients by v (chain rule), shape (m, v).

        Args:
            sample_indices: Indices of the samples.
            gradient: Gradients by v at these samples, shape (m, nv).
            car: Index of the car's first coordinate in v.
            other_indices: Indices of the other joints' coordinates in v.
        """
        n, k = len(self.segments), len(other_indices)
        by_car = np.einsum(
            "mi,mij->mj", gradient[:, car : car + 3], self.segment_poses.jacobians[sample_indices]
        )
        if not k or n == 1:
            return by_car
        by_other = np.zeros((len(sample_indices), n + 1, k))
        rows, segments = np.arange(len(sample_indices)), self.samples.segments[sample_indices]
        fractions = self.samples.fractions[sample_indices][:, None]
        by_other[rows, segments] = (1 - fractions) * gradient[:, other_indices]
        by_other[rows, segments + 1] += fractions * gradient[:, other_indices]
        return np.concatenate([by_car, by_other[:, 1:-1].reshape(len(sample_indices), -1)], axis=1)
