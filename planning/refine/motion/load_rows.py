"""LoadRows: loads of a spline motion at instants, with gradients."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.refine.constraints.load import Load
from planning.refine.curves.bspline_basis import ORDER, basis_weights
from planning.refine.motion.spline_matrices import SplineMatrices, matrices_at, split


@dataclass(frozen=True)
class LoadRows:
    """Squared norms of a load's ratios at instants, which must not exceed 1.

    Attributes:
        load: Torques, or rates of frames.
        num_control_points: Of the motion.
        matrices: At the instants.
        control_points: Indices of those that matter at each instant, shape (m, 4).
    """

    load: Load
    num_control_points: int
    matrices: SplineMatrices
    control_points: Indices

    @classmethod
    def of(cls, load: Load, num_control_points: int) -> "LoadRows":
        """Build the rows at the middle of every span and at every knot between."""
        spans = num_control_points - ORDER + 1
        instants = np.linspace(0.0, 1.0, 2 * spans + 1)[1:-1]
        matrices = matrices_at(num_control_points, instants)
        control_points = basis_weights(num_control_points, instants).control_points
        return cls(load, num_control_points, matrices, control_points)

    def values(self, points: Array, duration: float) -> Array:
        """Return the squared norms of a motion, shape (m, balls)."""
        return (self.load.load_ratios(*self.matrices.states(points, duration)) ** 2).sum(axis=-1)

    def __call__(self, x: Float64[np.ndarray, " n"]) -> tuple[Array, Array]:
        """Return the squared norms, and their gradients."""
        points, duration = split(x, self.num_control_points)
        q, v, vdot = self.matrices.states(points, duration)
        ratios = self.load.load_ratios(q, v, vdot)
        by_state = 2 * np.einsum("mbd,ambdk->ambk", ratios, self.load.derivatives(q, v, vdot))
        by_time = -(by_state[1] * v[:, None] + 2 * by_state[2] * vdot[:, None]).sum(axis=-1)
        scales = np.array([1.0, 1 / duration, 1 / duration**2])
        by_points = np.einsum("a,amc,ambk->mbck", scales, self.matrices.by_order[:3], by_state)
        values = (ratios**2).sum(axis=-1)
        gradients = np.concatenate(
            [by_points.reshape(values.size, -1), by_time.reshape(-1, 1) / duration], axis=1
        )
        return values.ravel(), gradients

    def num_rows(self, num_coordinates: int) -> int:
        """Return the number of rows."""
        still = np.zeros((1, num_coordinates))
        return self.matrices.by_order.shape[1] * self.load.load_ratios(still, still, still).shape[1]
