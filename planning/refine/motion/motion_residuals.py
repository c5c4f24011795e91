"""Residuals: the objective of a spline motion as a sum of squares, linearized.

Squares of linear functions make a convex model of the cost (Gauss and Newton). Smoothness and
energy are integrals of squares; a length |r'| is at most |r'|^2 / (2 c) + c / 2, with equality
where c = |r'|: the bound is what the model minimizes.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planning.domain.arrays import Array, Indices
from planning.refine.constraints.load import difference_quotients
from planning.refine.curves.bspline_basis import basis_weights
from planning.refine.motion.motion_cost import MotionCost
from planning.refine.motion.spline_matrices import quadrature, quadrature_nodes

# Nodes per span: exact for squared accelerations and jerks.
NUM_NODES = 2
# Least speed whose length counts in full, as a share of the mean speed along the curve.
_LEAST_SPEED_SHARE = 0.02


@dataclass(frozen=True)
class Residuals:
    """Values e(P, T) at nodes, whose squares add up to a part of the cost, with derivatives.

    Attributes:
        values: e, shape (m, nq).
        control_points: Indices of the control points that matter at each node, shape (m, 4).
        by_point: Derivatives by these: by their own coordinate, shape (m, nq, 4), or by all
            coordinates, shape (m, nq, 4, nq).
        by_time: Derivatives by the logarithm of the duration, shape (m, nq).
    """

    values: Array
    control_points: Indices
    by_point: Array
    by_time: Array

    def rows(
        self, point_columns: Indices, time_column: int, radii: Array
    ) -> tuple[Indices, Array, Array]:
        """Return columns and entries of the derivatives, shape (m nq, entries) each, and values.

        Args:
            point_columns: Columns of control points, shape (k, nq).
            time_column: Column of the logarithm of the duration.
            radii: Units of the control points' steps, shape (nq,).
        """
        m, nq = self.values.shape
        columns = point_columns[self.control_points]
        if self.by_point.ndim == 3:
            columns, entries = columns.transpose(0, 2, 1), self.by_point * radii[:, None]
        else:
            columns = np.broadcast_to(columns.reshape(m, 1, -1), (m, nq, 4 * nq))
            entries = (self.by_point * radii).reshape(m, nq, -1)
        time_columns = np.full((m, nq, 1), time_column)
        columns = np.concatenate([columns, time_columns], axis=2)
        entries = np.concatenate([entries, self.by_time[:, :, None]], axis=2)
        return columns.reshape(m * nq, -1), entries.reshape(m * nq, -1), self.values.ravel()


def cost_residuals(cost: MotionCost, points: Array, duration: float) -> Iterator[Residuals]:
    """Yield the residuals of every objective with a weight, but for the duration.

    Args:
        cost: The objective.
        points: Control points, shape (k, nq).
        duration: [s].
    """
    objective = cost.objective
    if objective.smoothness:
        order = objective.derivative_order
        scale, power = duration ** (0.5 - order), 0.5 - order
        yield _rates(points, order, np.sqrt(objective.smoothness) * scale, power)
    if objective.path_length:
        yield _rates(points, 1, np.sqrt(objective.path_length) * _length_scales(points), 0.0)
    if objective.energy:
        yield _efforts(cost, points, duration)


def _rates(points: Array, order: int, scale: Array | float, power: float) -> Residuals:
    """Return residuals proportional to a derivative of the curve, and to a power of T."""
    at = quadrature(len(points), NUM_NODES)
    weights = basis_weights(len(points), quadrature_nodes(len(points), NUM_NODES), order)
    scales = np.broadcast_to(np.sqrt(at.weights) * scale, at.weights.shape)
    values = scales[:, None] * (at.by_order[order] @ points)
    by_point = np.broadcast_to(
        (scales[:, None] * weights.values)[:, None], (*values.shape, weights.values.shape[1])
    )
    return Residuals(values, weights.control_points, by_point, power * values)


def _length_scales(points: Array) -> Array:
    """Return 1 / sqrt(2 |r'|) at the nodes."""
    at = quadrature(len(points), NUM_NODES)
    speeds = np.linalg.norm(at.by_order[1] @ points, axis=1)
    least = max(_LEAST_SPEED_SHARE * float(at.weights @ speeds), 1e-9)
    return 1 / np.sqrt(2 * np.maximum(speeds, least))


def _efforts(cost: MotionCost, points: Array, duration: float) -> Residuals:
    at = quadrature(len(points), NUM_NODES)
    q, v, vdot = at.states(points, duration)
    scales = np.sqrt(cost.objective.energy * at.weights * duration)[:, None]
    values = scales * cost.efforts(q, v, vdot)
    by_state = scales[..., None] * difference_quotients(cost.efforts, q, v, vdot)
    by_time = values / 2 - np.einsum("mij,mj->mi", by_state[1], v)
    by_time -= 2 * np.einsum("mij,mj->mi", by_state[2], vdot)
    nodes, by_point = quadrature_nodes(len(points), NUM_NODES), 0.0
    for order in range(3):
        weights = basis_weights(len(points), nodes, order).values / duration**order
        by_point = by_point + np.einsum("mij,mc->micj", by_state[order], weights)
    control_points = basis_weights(len(points), nodes).control_points
    return Residuals(values, control_points, np.asarray(by_point), by_time)
