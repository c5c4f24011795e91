"""CurveSamples: q, v and vdot of a motion at sample points of every interval of the velocity grid.

Every interval is cut into equal parts, and the samples are the ends of these parts. There

    v = r' sqrt(b),  vdot = r'' b + r' u,

where r and its derivatives are weighted sums of control points and u of an interval is (b_high -
b_low) / (2 h): by the chain rule, derivatives with respect to q, v and vdot give those with respect
to control points and path velocity.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.refine.curves.bspline_basis import basis_weights
from planning.refine.curves.path_velocity import path_grid


@dataclass(frozen=True)
class GridWeights:
    """Weights of control points for r, r' and r'' at the ends of parts of the grid's intervals.

    Every interval has its own: at a knot the spans on both sides have other control points.

    Attributes:
        control_points: Indices of the control points of each interval, shape (n, 4).
        values: Their weights, shape (3, n, parts + 1, 4).
    """

    control_points: Indices
    values: Array

    def along(self, points: Float64[np.ndarray, "k nq"]) -> Float64[np.ndarray, "3 m nq"]:
        """Return r, r' and r'' at the ends of parts, m = n parts + 1, each once."""
        ends = np.einsum("onpk,nkj->onpj", self.values, points[self.control_points])
        firsts = ends[:, :, :-1].reshape(3, -1, points.shape[1])
        return np.concatenate([firsts, ends[:, -1:, -1]], axis=1)


@lru_cache(maxsize=16)
def grid_weights(num_control_points: int, num_parts: int = 1) -> GridWeights:
    """Return the weights for a number of control points, at `num_parts` parts per grid interval."""
    control_points = path_grid(num_control_points).control_points
    n = len(control_points)
    ends = (np.arange(n)[:, None] + np.arange(num_parts + 1) / num_parts) / n
    spans = np.repeat(control_points[:, 0], num_parts + 1)
    weights = [basis_weights(num_control_points, ends.ravel(), k, spans).values for k in range(3)]
    return GridWeights(control_points, np.stack(weights).reshape(3, n, num_parts + 1, 4))


@dataclass(frozen=True)
class CurveSamples:
    """Samples of a motion, each on one interval of the grid.

    Attributes:
        step: Width of an interval.
        table: Weights of control points by interval and part of it.
        curve_states: r, r' and r'' at the ends of all parts, shape (3, n parts + 1, nq).
        grid_indices: Which of these each sample has, shape (m,).
        intervals: Index of each sample's interval, on which u is constant, shape (m,).
        interval_ends: b at both ends of the interval, shape (m, 2).
    """

    step: float
    table: GridWeights
    curve_states: Array
    grid_indices: Indices
    intervals: Indices
    interval_ends: Array

    @classmethod
    def of(
        cls,
        num_control_points: int,
        states: Float64[np.ndarray, "3 m nq"],
        b: Float64[np.ndarray, " n_plus_1"],
        num_parts: int = 1,
    ) -> "CurveSamples":
        """Return both ends of every part of every interval.

        Args:
            num_control_points: Number of control points.
            states: r, r' and r'' at the ends of parts, m = n parts + 1.
            b: Squared path velocity at the grid.
            num_parts: Number of parts of an interval.
        """
        table = grid_weights(num_control_points, num_parts)
        intervals, grid_indices = _all_samples(len(b) - 1, num_parts)
        interval_ends = np.stack([b[intervals], b[intervals + 1]], axis=1)
        step = path_grid(num_control_points).step
        return cls(step, table, states, grid_indices, intervals, interval_ends)

    def selected(self, which: Indices) -> "CurveSamples":
        """Return the selected samples."""
        return CurveSamples(
            self.step,
            self.table,
            self.curve_states,
            self.grid_indices[which],
            self.intervals[which],
            self.interval_ends[which],
        )

    @property
    def num_parts(self) -> int:
        """Number of parts of an interval."""
        return self.table.values.shape[2] - 1

    @cached_property
    def fractions(self) -> Float64[np.ndarray, " m"]:
        """Fraction of the interval before each sample."""
        return self._parts / self.num_parts

    @cached_property
    def b(self) -> Float64[np.ndarray, " m"]:
        """Squared path velocity at each sample [1/s^2]."""
        low, high = self.interval_ends.T
        return (1 - self.fractions) * low + self.fractions * high

    @cached_property
    def u(self) -> Float64[np.ndarray, " m"]:
        """Path acceleration at each sample [1/s^2]."""
        return (self.interval_ends[:, 1] - self.interval_ends[:, 0]) / (2 * self.step)

    @cached_property
    def states(self) -> Float64[np.ndarray, "3 m nq"]:
        """Return r, r' and r'' at each sample."""
        return self.curve_states[:, self.grid_indices]

    @cached_property
    def weights(self) -> Float64[np.ndarray, "3 m 4"]:
        """Weights of control points for r, r' and r'' at each sample."""
        return self.table.values[:, self.intervals, self._parts]

    @cached_property
    def control_points(self) -> Indices:
        """Indices of the control points with these weights, shape (m, 4)."""
        return self.table.control_points[self.intervals]

    @property
    def motion(self) -> tuple[Array, Array, Array]:
        """Configuration q, velocity v and acceleration vdot, each of shape (m, nq)."""
        q, rate, curvature = self.states
        b, u = self.b[:, None], self.u[:, None]
        return q, rate * np.sqrt(b), curvature * b + rate * u

    def by_control_point(self, by_q: Array, by_v: Array, by_vdot: Array) -> Array:
        """Return derivatives by coordinates of 4 control points, shape (m, rows, 4, nq).

        Args:
            by_q: Derivatives by q, shape (m, rows, nq).
            by_v: Derivatives by v, likewise.
            by_vdot: Derivatives by vdot, likewise.
        """
        b, u = self.b[:, None, None], self.u[:, None, None]
        by_state = np.stack([by_q, np.sqrt(b) * by_v + u * by_vdot, b * by_vdot])
        weights = self.weights[:, :, None, :, None]
        return (weights * by_state[:, :, :, None]).sum(axis=0)

    def by_path_velocity(self, by_v: Array, by_vdot: Array) -> Array:
        """Return derivatives by b at both ends of the interval, times b, shape (m, rows, 2)."""
        _, rate, curvature = self.states
        by_b = np.einsum("mrj,mj->mr", by_v, rate * np.sqrt(self.b)[:, None] / 2)
        by_b += np.einsum("mrj,mj->mr", by_vdot, curvature * self.b[:, None])
        by_u = np.einsum("mrj,mj->mr", by_vdot, rate)
        changes = self.interval_ends * [-1.0, 1.0] / (2 * self.step)
        shares = self.interval_ends * np.stack([1 - self.fractions, self.fractions], axis=1)
        shares /= np.where(self.b > 0, self.b, 1.0)[:, None]
        return by_u[:, :, None] * changes[:, None] + by_b[:, :, None] * shares[:, None]

    @property
    def _parts(self) -> Indices:
        return self.grid_indices - self.intervals * self.num_parts


@lru_cache(maxsize=16)
def _all_samples(num_intervals: int, num_parts: int) -> tuple[Indices, Indices]:
    """Return the interval of both ends of every part, and the place of each along the curve."""
    intervals = np.repeat(np.arange(num_intervals), num_parts + 1)
    return intervals, intervals * num_parts + np.tile(np.arange(num_parts + 1), num_intervals)
