"""Matrices from control points to a cubic spline's derivatives at instants, and quadrature.

A motion of the program is q(t) = r(t / T) with r(s) = B(s) P: the control points P, shape (k, nq),
and the duration T are its variables, x = (P row by row, T).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.refine.curves.bspline_basis import ORDER, basis_weights, num_spans


@dataclass(frozen=True)
class SplineMatrices:
    """Derivatives of a spline at instants.

    Attributes:
        by_order: Matrices of r, r', r'' and r''', shape (4, m, k).
        weights: Of the instants in an integral over s, shape (m,).
    """

    by_order: Array
    weights: Array

    def states(self, points: Array, duration: float) -> tuple[Array, Array, Array]:
        """Return q, v and vdot of a motion at the instants, shape (m, nq) each."""
        position, first, second = (matrix @ points for matrix in self.by_order[:3])
        return position, first / duration, second / duration**2


def split(x: Float64[np.ndarray, " n"], num_control_points: int) -> tuple[Array, float]:
    """Return the control points and the duration of x."""
    return x[:-1].reshape(num_control_points, -1), float(x[-1])


def matrices_at(num_control_points: int, s: Float64[np.ndarray, " m"]) -> SplineMatrices:
    """Return the matrices at instants s in [0, 1], of equal weight."""
    by_order = np.stack([_dense(num_control_points, s, order) for order in range(4)])
    return SplineMatrices(by_order, np.full(len(s), 1 / max(len(s), 1)))


@lru_cache(maxsize=8)
def quadrature(num_control_points: int, nodes_per_span: int) -> SplineMatrices:
    """Return the matrices at Gauss-Legendre nodes of every span: integrals over s in [0, 1]."""
    spans = num_spans(num_control_points)
    found = matrices_at(num_control_points, quadrature_nodes(num_control_points, nodes_per_span))
    weights = np.polynomial.legendre.leggauss(nodes_per_span)[1]
    return SplineMatrices(found.by_order, np.tile(weights / (2 * spans), spans))


def quadrature_nodes(num_control_points: int, nodes_per_span: int) -> Array:
    """Return the nodes of `quadrature`, instants in (0, 1)."""
    spans = num_spans(num_control_points)
    nodes = np.polynomial.legendre.leggauss(nodes_per_span)[0]
    return ((np.arange(spans)[:, None] + (nodes + 1) / 2) / spans).ravel()


def _dense(num_control_points: int, s: Array, order: int) -> Array:
    weights = basis_weights(num_control_points, s, order)
    matrix = np.zeros((len(s), num_control_points))
    np.put_along_axis(matrix, weights.control_points, weights.values, axis=1)
    return matrix


@lru_cache(maxsize=8)
def rate_maps(num_control_points: int, order: int) -> tuple[Array, Array]:
    """Return the matrix to the control points of r^(order), and its inverse from rest at zero.

    The inverse gives the control points of the spline that has these rates, and zero position and
    lower derivatives at s = 0.
    """
    inner = np.linspace(0.0, 1.0, num_spans(num_control_points) + 1)
    knots = np.concatenate([np.zeros(ORDER - 1), inner, np.ones(ORDER - 1)])
    current = np.eye(num_control_points)
    starts: list[Array] = []
    for k in range(1, order + 1):
        starts.append(current[:1])
        degree = ORDER - k
        widths = (knots[degree:] - knots[:-degree])[k : k + len(current) - 1]
        current = degree * np.diff(current, axis=0) / widths[:, None]
    square = np.vstack([current, *starts])
    return current, np.linalg.inv(square)[:, : len(current)]
