"""MarginRows: rows of Drake's program that keep distances at instants."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.refine.constraints.distance_query import DistanceQuery
from planning.refine.curves.bspline_basis import ORDER, BasisWeights, basis_weights
from planning.refine.motion.spline_matrices import split

# Signed margin above which pairs are ignored [m].
_INFLUENCE_DISTANCE = 0.1
# Pairs that count at each instant, the nearest ones.
_NUM_PAIRS = 3


@dataclass(frozen=True)
class MarginRows:
    """Signed margins of the nearest pairs of bodies at instants, which must not be negative.

    The k-th row of an instant is the k-th smallest margin: where two pairs change places, so do
    their gradients, and a program that is linear in the rows sees no change. Margins of path
    constraints are among them.

    Attributes:
        query: Distances, in the coordinates of the control points.
        num_control_points: Of the motion.
        weights: Of the control points at the instants.
    """

    query: DistanceQuery
    num_control_points: int
    weights: BasisWeights

    @classmethod
    def at(
        cls,
        instants: Float64[np.ndarray, " m"],
        query: DistanceQuery,
        num_control_points: int,
    ) -> "MarginRows":
        """Build the rows of instants in (0, 1)."""
        weights = basis_weights(num_control_points, instants)
        return cls(query, num_control_points, weights)

    @property
    def num_rows(self) -> int:
        """Number of rows."""
        return len(self.weights.values) * _NUM_PAIRS

    def sparsity(self, num_coordinates: int) -> list[tuple[int, int]]:
        """Return rows and columns of the gradients that are not always zero."""
        columns = self._columns(num_coordinates)
        return [
            (row, int(column))
            for row in range(self.num_rows)
            for column in columns[row // _NUM_PAIRS]
        ]

    def __call__(self, x: Float64[np.ndarray, " n"]) -> tuple[Array, Array]:
        """Return the margins, and their gradients."""
        points, _ = split(x, self.num_control_points)
        rows = self.query.within(self.weights.apply(points), _INFLUENCE_DISTANCE)
        order = np.lexsort((rows.signed_margins, rows.sample_indices))
        instants = rows.sample_indices[order]
        ranks = np.arange(len(order)) - np.searchsorted(instants, instants)
        order, instants, ranks = (part[ranks < _NUM_PAIRS] for part in (order, instants, ranks))
        margins = np.full(self.num_rows, _INFLUENCE_DISTANCE)
        gradients = np.zeros((self.num_rows, len(x)))
        targets = instants * _NUM_PAIRS + ranks
        margins[targets] = rows.signed_margins[order]
        slopes = self.weights.values[instants][:, :, None] * rows.gradients[order][:, None]
        columns = self._columns(points.shape[1])[instants]
        gradients[targets[:, None], columns] = slopes.reshape(columns.shape)
        return margins, gradients

    def _columns(self, num_coordinates: int) -> Indices:
        first = self.weights.control_points[:, :1] * num_coordinates
        return first + np.arange(ORDER * num_coordinates)
