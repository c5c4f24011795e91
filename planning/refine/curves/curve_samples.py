"""CurveSamples: q, v and vdot of a motion at sample points of every interval of the velocity grid.

Every interval is cut into equal parts, and the samples are the ends of these parts. There

    v = r' sqrt(b),  vdot = r'' b + r' u,

where r and its derivatives are weighted sums of control points and u of an interval is (b_high -
b_low) / (2 h): by the chain rule, derivatives with respect to q, v and vdot give those with respect
to control points and path velocity.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.refine.curves.bspline_basis import weights_at
from planning.refine.curves.path_velocity import grid_of


@dataclass(frozen=True)
class GridWeights:
    """Weights of control points for r, r' and r'' at the ends of parts of the grid's intervals.

    Attributes:
        owners: Indices of the control points with nonzero weight, shape (n parts + 1, 4).
        local: Their weights, shape (3, n parts + 1, 4).
    """

    owners: Indices
    local: Array


@lru_cache(maxsize=16)
def grid_weights(count: int, parts: int = 1) -> GridWeights:
    """Return the weights for a number of control points, at `parts` parts per grid interval."""
    n = len(grid_of(count).owners) * parts
    found = [weights_at(count, np.arange(n + 1) / n, order) for order in range(3)]
    return GridWeights(found[0].owners, np.stack([weights.local for weights in found]))


@dataclass(frozen=True)
class CurveSamples:
    """Samples of a motion, each on one interval of the grid.

    Attributes:
        step: Width of an interval.
        weights: Of control points.
        places: Rows of these weights, shape (m,).
        intervals: Index of each sample's interval, which has its u, shape (m,).
        shares: Fraction of the interval before the sample, shape (m,).
        states: r, r' and r'' at the samples, shape (3, m, nq).
        b: Squared path velocity at the samples, shape (m,).
        around: b at both ends of the interval, shape (m, 2).
    """

    step: float
    weights: GridWeights
    places: Indices
    intervals: Indices
    shares: Array
    states: Array
    b: Array
    around: Array

    @classmethod
    def of(
        cls,
        count: int,
        states: Float64[np.ndarray, "3 m nq"],
        b: Float64[np.ndarray, " n_plus_1"],
        parts: int = 1,
    ) -> "CurveSamples":
        """Return both ends of every part of every interval.

        Args:
            count: Number of control points.
            states: r, r' and r'' at the ends of parts, m = n parts + 1.
            b: Squared path velocity at the grid.
            parts: Number of parts of an interval.
        """
        n = len(b) - 1
        intervals = np.repeat(np.arange(n), parts + 1)
        within = np.tile(np.arange(parts + 1), n)
        places, shares = intervals * parts + within, within / parts
        around = np.stack([b[intervals], b[intervals + 1]], axis=1)
        return cls(
            grid_of(count).step,
            grid_weights(count, parts),
            places,
            intervals,
            shares,
            states[:, places],
            (1 - shares) * around[:, 0] + shares * around[:, 1],
            around,
        )

    def taken(self, which: Indices) -> "CurveSamples":
        """Return the selected samples."""
        return CurveSamples(
            self.step,
            self.weights,
            self.places[which],
            self.intervals[which],
            self.shares[which],
            self.states[:, which],
            self.b[which],
            self.around[which],
        )

    @property
    def motion(self) -> tuple[Array, Array, Array]:
        """Configuration q, velocity v and acceleration vdot, each of shape (m, nq)."""
        q, rate, curvature = self.states
        b, u = self.b[:, None], self._u[:, None]
        return q, rate * np.sqrt(b), curvature * b + rate * u

    def by_point(self, by_q: Array, by_v: Array, by_vdot: Array) -> Array:
        """Return derivatives by coordinates of 4 control points, shape (m, rows, 4, nq).

        Args:
            by_q: Derivatives by q, shape (m, rows, nq).
            by_v: By v, likewise.
            by_vdot: By vdot, likewise.
        """
        b, u = self.b[:, None, None], self._u[:, None, None]
        by_state = np.stack([by_q, np.sqrt(b) * by_v + u * by_vdot, b * by_vdot])
        local = self.weights.local[:, self.places, None, :, None]
        return (local * by_state[:, :, :, None]).sum(axis=0)

    def by_pace(self, by_v: Array, by_vdot: Array) -> Array:
        """Return derivatives by b at both ends of the interval, times b, shape (m, rows, 2)."""
        _, rate, curvature = self.states
        own = np.einsum("mrj,mj->mr", by_v, rate * np.sqrt(self.b)[:, None] / 2)
        own += np.einsum("mrj,mj->mr", by_vdot, curvature * self.b[:, None])
        ahead = np.einsum("mrj,mj->mr", by_vdot, rate)
        changes = self.around * [-1.0, 1.0] / (2 * self.step)
        parts = self.around * np.stack([1 - self.shares, self.shares], axis=1)
        parts /= np.where(self.b > 0, self.b, 1.0)[:, None]
        return ahead[:, :, None] * changes[:, None] + own[:, :, None] * parts[:, None]

    @property
    def owners(self) -> Indices:
        """Indices of the control points with nonzero weight at each sample, shape (m, 4)."""
        return self.weights.owners[self.places]

    @property
    def _u(self) -> Array:
        return (self.around[:, 1] - self.around[:, 0]) / (2 * self.step)
