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
from planning.kernel.native import native

# Order 4 is cubic pieces: acceleration is continuous, as both retimers require.
ORDER = 4
# Offset into a span of knots, so that derivatives that jump at knots are those of the span.
_SPAN_OFFSET = 1e-12


@dataclass(frozen=True)
class BasisWeights:
    """Weights of control points at some instants.

    Attributes:
        control_points: Indices of the control points with nonzero weight at each instant,
            shape (m, 4).
        values: Their weights, shape (m, 4).
    """

    control_points: Indices
    values: Array

    def apply(self, points: Float64[np.ndarray, "n nq"]) -> Array:
        """Return the weighted sums, shape (m, nq)."""
        return np.einsum("mk,mkj->mj", self.values, points[self.control_points])


def num_spans(num_control_points: int) -> int:
    """Return the number of knot spans of a spline with `num_control_points` control points."""
    return num_control_points - ORDER + 1


def basis_weights(
    num_control_points: int,
    s: Float64[np.ndarray, " m"],
    order: int = 0,
    spans: Int[np.ndarray, " m"] | None = None,
) -> BasisWeights:
    """Return the weights of `num_control_points` control points for a derivative.

    Args:
        num_control_points: Number of control points.
        s: Instants in [0, 1].
        order: Order of the derivative.
        spans: The span of knots from which each instant is evaluated; None for its own.
    """
    n = num_spans(num_control_points)
    if spans is None:
        spans = np.clip((s * n).astype(np.intp), 0, n - 1)
    low, high = spans / n, (spans + 1) / n
    inside = np.clip(s, low + _SPAN_OFFSET * (low > 0), high - _SPAN_OFFSET * (high < 1))
    unit: Any = _unit_spline(num_control_points)
    derivative = unit if order == 0 else unit.MakeDerivative(order)
    dense = derivative.vector_values(inside.tolist()).T
    control_points = spans[:, None] + np.arange(ORDER)
    return BasisWeights(control_points, np.take_along_axis(dense, control_points, axis=1))


def position_weights(num_control_points: int, s: Float64[np.ndarray, " m"]) -> BasisWeights:
    """Return the weights of the position itself at instants in [0, 1].

    By the kernel if it is there; as `basis_weights` but for rounding.
    """
    module: Any = native()
    if module is None:
        return basis_weights(num_control_points, s)
    first_points, values = module.spline_weights(num_control_points, s)
    return BasisWeights(first_points[:, None] + np.arange(ORDER), values)


def even_positions(points: Float64[np.ndarray, "n nq"], num_intervals: int) -> Array:
    """Return positions of a spline at s = i / num_intervals, shape (num_intervals + 1, nq)."""
    module: Any = native()
    if module is None:
        s = np.linspace(0.0, 1.0, num_intervals + 1)
        return basis_weights(len(points), s).apply(points)
    return module.spline_positions(np.ascontiguousarray(points), num_intervals)


def make_bspline(
    control_points: Float64[np.ndarray, "n nq"], duration: float = 1.0
) -> BsplineTrajectory:
    """Return Drake's clamped uniform cubic B-spline on [0, duration]."""
    num_control_points = len(control_points)
    basis = BsplineBasis(ORDER, num_control_points, KnotVectorType.kClampedUniform, 0.0, duration)
    return BsplineTrajectory(basis, [point[:, None] for point in control_points])


def greville_abscissae(num_control_points: int) -> Array:
    """Return the Greville abscissa of each control point, its instant on the curve."""
    inner = np.linspace(0.0, 1.0, num_spans(num_control_points) + 1)
    knots = np.concatenate([np.zeros(ORDER - 1), inner, np.ones(ORDER - 1)])
    return np.array([knots[k + 1 : k + ORDER].mean() for k in range(num_control_points)])


@lru_cache(maxsize=8)
def _unit_spline(num_control_points: int) -> BsplineTrajectory:
    """Return the spline whose coordinates are the basis functions."""
    return make_bspline(np.eye(num_control_points))
