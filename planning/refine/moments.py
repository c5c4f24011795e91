"""Moments: a motion along a curve at both ends of every interval of the pace's grid.

v = r' sqrt(b) and vdot = r'' b + r' u, where r and its derivatives are weighted sums of control
points and u of an interval is (b_high - b_low) / (2 h): by the chain rule, slopes with respect to
q, v and vdot are slopes with respect to control points and pace.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.refine.basis import weights_at
from planning.refine.pace import grid_of

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]


@dataclass(frozen=True)
class GridWeights:
    """How r, r' and r'' at the points of the pace's grid depend on control points.

    Attributes:
        owners: The control points that matter, shape (n + 1, 4).
        local: Their weights, shape (3, n + 1, 4).
    """

    owners: Indices
    local: Array


@lru_cache(maxsize=8)
def grid_weights(count: int) -> GridWeights:
    """Return the weights of a number of control points."""
    n = len(grid_of(count).owners)
    found = [weights_at(count, np.arange(n + 1) / n, order) for order in range(3)]
    return GridWeights(found[0].owners, np.stack([weights.local for weights in found]))


@dataclass(frozen=True)
class Moments:
    """Some ends of some intervals.

    Attributes:
        count: How many control points there are.
        places: Which points of the grid, shape (m,).
        intervals: Of which u is, shape (m,).
        states: r, r' and r'' there, shape (3, m, nq).
        b: There, shape (m,).
        around: b at both ends of the interval, shape (m, 2).
    """

    count: int
    places: Indices
    intervals: Indices
    states: Array
    b: Array
    around: Array

    @classmethod
    def of(
        cls,
        count: int,
        states: Float64[np.ndarray, "3 n_plus_1 nq"],
        b: Float64[np.ndarray, " n_plus_1"],
    ) -> "Moments":
        """Return both ends of every interval.

        Args:
            count: How many control points there are.
            states: r, r' and r'' at the grid's points.
            b: The pace there.
        """
        intervals = np.repeat(np.arange(len(b) - 1), 2)
        places = intervals + np.tile([0, 1], len(b) - 1)
        around = np.stack([b[intervals], b[intervals + 1]], axis=1)
        return cls(count, places, intervals, states[:, places], b[places], around)

    def taken(self, which: Indices) -> "Moments":
        """Return those only."""
        return Moments(
            self.count,
            self.places[which],
            self.intervals[which],
            self.states[:, which],
            self.b[which],
            self.around[which],
        )

    @property
    def motion(self) -> tuple[Array, Array, Array]:
        """q, v and vdot, each of shape (m, nq)."""
        q, rate, curvature = self.states
        b, u = self.b[:, None], self._u[:, None]
        return q, rate * np.sqrt(b), curvature * b + rate * u

    def by_point(self, by_q: Array, by_v: Array, by_vdot: Array) -> Array:
        """Return slopes by coordinates of 4 control points, shape (m, rows, 4, nq).

        Args:
            by_q: Slopes by q, shape (m, rows, nq).
            by_v: By v, likewise.
            by_vdot: By vdot, likewise.
        """
        b, u = self.b[:, None, None], self._u[:, None, None]
        by_state = np.stack([by_q, np.sqrt(b) * by_v + u * by_vdot, b * by_vdot])
        local = grid_weights(self.count).local[:, self.places, None, :, None]
        return (local * by_state[:, :, :, None]).sum(axis=0)

    def by_pace(self, by_v: Array, by_vdot: Array) -> Array:
        """Return slopes by b at both ends of the interval, relative to it, shape (m, rows, 2)."""
        _, rate, curvature = self.states
        own = np.einsum("mrj,mj->mr", by_v, rate * np.sqrt(self.b)[:, None] / 2)
        own += np.einsum("mrj,mj->mr", by_vdot, curvature * self.b[:, None])
        ahead = np.einsum("mrj,mj->mr", by_vdot, rate)
        changes = self.around * [-1.0, 1.0] / (2 * grid_of(self.count).step)
        slopes = ahead[:, :, None] * changes[:, None]
        slopes[np.arange(len(own)), :, self.places - self.intervals] += own
        return slopes

    @property
    def _u(self) -> Array:
        return (self.around[:, 1] - self.around[:, 0]) / (2 * grid_of(self.count).step)
