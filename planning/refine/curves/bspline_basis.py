"""B-spline basis: clamped uniform cubic splines as weights of control points, with derivatives.

r(s) = sum_k w_k(s) P[first(s) + k], k = 0..3, and likewise with other weights for its derivatives.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float64, Int
from pydrake.math import BsplineBasis, KnotVectorType
from pydrake.trajectories import BsplineTrajectory

from planning.domain.arrays import Array, Indices

# Order 4 is cubic pieces: acceleration is continuous, as both retimers require.
ORDER = 4
# Offset into a span of knots, so that derivatives that jump at knots are those of the span.
_INSIDE = 1e-12


@dataclass(frozen=True)
class Weights:
    """Weights of control points at some instants.

    Attributes:
        owners: Indices of the control points with nonzero weight at each instant, shape (m, 4).
        local: Their weights, shape (m, 4).
    """

    owners: Indices
    local: Array

    def of(self, points: Float64[np.ndarray, "n nq"]) -> Array:
        """Return the weighted sums, shape (m, nq)."""
        return np.einsum("mk,mkj->mj", self.local, points[self.owners])


def num_spans(count: int) -> int:
    """Return the number of knot spans of a spline with `count` control points."""
    return count - ORDER + 1


def weights_at(
    count: int,
    s: Float64[np.ndarray, " m"],
    order: int = 0,
    spans: Int[np.ndarray, " m"] | None = None,
) -> Weights:
    """Return the weights of `count` control points for the derivative of the given order.

    Args:
        count: Number of control points.
        s: Instants in [0, 1].
        order: Of the derivative.
        spans: The span of knots from which each instant is evaluated; None for its own.
    """
    if spans is None:
        spans = np.clip((s * num_spans(count)).astype(np.intp), 0, num_spans(count) - 1)
    low, high = spans / num_spans(count), (spans + 1) / num_spans(count)
    inside = np.clip(s, low + _INSIDE * (low > 0), high - _INSIDE * (high < 1))
    unit: Any = _unit_spline(count) if order == 0 else _unit_spline(count).MakeDerivative(order)
    dense = unit.vector_values(inside.tolist()).T
    owners = spans[:, None] + np.arange(ORDER)
    return Weights(owners, np.take_along_axis(dense, owners, axis=1))


def spline_of(
    control_points: Float64[np.ndarray, "n nq"], duration: float = 1.0
) -> BsplineTrajectory:
    """Return Drake's clamped uniform cubic B-spline on [0, duration]."""
    count = len(control_points)
    basis = BsplineBasis(ORDER, count, KnotVectorType.kClampedUniform, 0.0, duration)
    return BsplineTrajectory(basis, [point[:, None] for point in control_points])


def centres(count: int) -> Array:
    """Return the Greville abscissa of each control point, its instant on the curve."""
    inner = np.linspace(0.0, 1.0, num_spans(count) + 1)
    knots = np.concatenate([np.zeros(ORDER - 1), inner, np.ones(ORDER - 1)])
    return np.array([knots[k + 1 : k + ORDER].mean() for k in range(count)])


@lru_cache(maxsize=8)
def _unit_spline(count: int) -> BsplineTrajectory:
    """Return the spline whose coordinates are the basis functions."""
    return spline_of(np.eye(count))
