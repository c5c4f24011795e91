"""Minimum-time path velocity of a curve, rest to rest: b = (ds/dt)^2 [1/s^2] at points of a grid.

On each interval of the grid d2s/dt2 is constant, u_i = (b_{i+1} - b_i) / (2 h). At both ends of
every interval velocity r' sqrt(b) and acceleration r'' b + r' u are bounded: time-optimal path
parametrisation (Verscheure et al., "Time-optimal path tracking for robots", 2009), which the
retimer repeats later on a finer grid. Of the jerk only r''' b^(3/2) is bounded, the curve's own
part at constant ds/dt; the retimer bounds the rest.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.curves.bspline_basis import num_spans, weights_at
from planning.refine.model.path_velocity_rows import (
    RATE_PENALTY,
    STANDSTILL,
    PathVelocityConstraints,
)
from planning.refine.model.penalty_qp import PenaltyQp, PenaltyRows

_PER_SPAN = 4
# Number of rows above which the solver begins with a subset of them, and that subset's stride.
_MANY, _EVERY = 1500, 6
# Violation above which a row counts as broken, as a share of its bound.
_DUST = 1e-6
# Least b as a share of its cap, so that the motion stops nowhere between its ends.
_SLOWEST = 1e-9


@dataclass(frozen=True)
class PathGrid:
    """Grid of n intervals, each within a span of knots, with weights of derivatives at their ends.

    Attributes:
        step: Width of an interval.
        owners: Indices of the control points with nonzero weight on each interval, shape (n, 4).
        first: Weights of r' at both ends of each, shape (n, 2, 4).
        second: Weights of r'', likewise.
        third: Weights of r''', shape (n, 4).
    """

    step: float
    owners: Indices
    first: Array
    second: Array
    third: Array


@lru_cache(maxsize=8)
def grid_of(count: int) -> PathGrid:
    """Return the grid for a number of control points."""
    n = num_spans(count) * _PER_SPAN
    spans = np.arange(n) // _PER_SPAN
    low, high = np.arange(n) / n, np.arange(1, n + 1) / n
    first, second = (
        np.stack([weights_at(count, s, order, spans).local for s in (low, high)], axis=1)
        for order in (1, 2)
    )
    third = weights_at(count, (low + high) / 2, 3, spans)
    return PathGrid(1 / n, third.owners, first, second, third.local)


@dataclass(frozen=True)
class NormalizedDerivatives:
    """Derivatives of a curve by s, over the bounds on rates.

    Attributes:
        speed: r' over velocity, shape (n, 2, nq).
        pull: r' over acceleration, likewise.
        bend: r'' over acceleration, likewise.
        swing: r''' over jerk, or zero, shape (n, nq).
        signed: Lowest and highest of what `accelerations` returns, shape (2, nq).
    """

    speed: Array
    pull: Array
    bend: Array
    swing: Array
    signed: Array

    @classmethod
    def of(
        cls, grid: PathGrid, points: Float64[np.ndarray, "k nq"], bounds: RateBounds
    ) -> "NormalizedDerivatives":
        """Return the derivatives of the curve with these control points."""
        owned = points[grid.owners]
        first, second = grid.first @ owned, grid.second @ owned
        swing = np.zeros_like(first[:, 0])
        if bounds.jerk is not None:
            swing = np.einsum("nk,nkj->nj", grid.third, owned) / bounds.jerk
        return cls(
            first / bounds.velocity,
            first / bounds.acceleration,
            second / bounds.acceleration,
            swing,
            bounds.signed,
        )

    def caps(self) -> Array:
        """Return bounds on b from velocity and jerk at every grid point but the ends [1/s^2]."""
        fastest = np.abs(self.speed[1:, 0]).max(axis=1)
        swing = np.abs(self.swing).max(axis=1)
        wildest = np.maximum(swing[1:], swing[:-1])
        return 1 / np.maximum(np.maximum(fastest**2, wildest ** (2 / 3)), STANDSTILL)

    def accelerations(self, grid: PathGrid, b: Float64[np.ndarray, " n_plus_1"]) -> Array:
        """Return acceleration over the larger of its bounds, shape (n, 2, nq)."""
        u = np.diff(b) / (2 * grid.step)
        return self.bend * both_ends(b)[..., None] + self.pull * u[:, None, None]

    def worst(self, grid: PathGrid, b: Float64[np.ndarray, " n_plus_1"]) -> float:
        """Return the largest acceleration over the bound of its sign, 1 at the bound."""
        return float((self.accelerations(grid, b)[..., None, :] / self.signed).max())

    def slopes(self, grid: PathGrid) -> tuple[Array, Array]:
        """Return the derivatives of accelerations by b at the low and high ends of intervals."""
        a = self.pull / (2 * grid.step)
        at_low, at_high = -a, a.copy()
        at_low[:, 0] += self.bend[:, 0]
        at_high[:, 1] += self.bend[:, 1]
        return at_low, at_high


def both_ends(b: Any) -> Any:
    """Return values at grid points for both ends of every interval, shape (n, 2)."""
    return np.stack([b[:-1], b[1:]], axis=1)


def minimum_time_path_velocity(
    grid: PathGrid, rates: NormalizedDerivatives, others: PathVelocityConstraints | None = None
) -> Float64[np.ndarray, " n_plus_1"]:
    """Return the largest admissible squared path velocity b [1/s^2] at the grid.

    It is the largest at every grid point at once (Pham and Pham, "A new approach to time-optimal
    path parameterization based on reachability analysis", 2018), so that maximising a sum gives it.
    """
    n = len(grid.owners)
    inner = rates.caps() if others is None else np.minimum(rates.caps(), others.caps())
    caps = np.concatenate([[0.0], inner, [0.0]])
    at_low, at_high = rates.slopes(grid)
    values = np.stack(
        [at_low * caps[:-1, None, None], at_high * caps[1:, None, None]], axis=-1
    ).transpose(0, 2, 1, 3)
    number = np.concatenate([[-1], np.arange(n - 1), [-1]])
    columns = np.broadcast_to(both_ends(number)[:, None, None], values.shape)
    now = np.zeros(values.shape[:-1])
    rows = PenaltyRows.between(columns, values, now, rates.signed[:, None, :, None], RATE_PENALTY)
    rows = rows.taken(np.minimum(rows.values, 0).sum(axis=1) < -1)
    extra = None if others is None else others.rows(caps, both_ends(number))
    b = np.zeros(n + 1)
    b[1:-1] = np.clip(_most(n - 1, rows, extra), _SLOWEST, 1.0) * caps[1:-1]
    # The solver satisfies rows to its tolerance; b is scaled down as a whole by the worst
    # violation.
    worst = rates.worst(grid, b)
    return b / max(1.0, worst if others is None else max(worst, others.worst(b)))


def _most(size: int, rows: PenaltyRows, extra: PenaltyRows | None) -> Array:
    """Return the largest x in [0, 1]^size that satisfies rows, each near 1 where nothing binds.

    Most rows of a large `extra` bind nowhere: a subset is used at first, then violated rows are
    added.
    """
    flat = np.full(size, -1 / size), np.zeros(size), np.zeros(size), np.ones(size)
    if extra is None:
        return PenaltyQp(*flat, (rows,)).solve()
    kept = np.full(len(extra.least), len(extra.least) < _MANY)
    kept[::_EVERY] = True
    while True:
        x = PenaltyQp(*flat, (rows, extra.taken(kept))).solve()
        broken = extra.lacks(x) > _DUST
        if not (broken & ~kept).any():
            return x
        kept |= broken


def duration_of(grid: PathGrid, b: Float64[np.ndarray, " n_plus_1"]) -> float:
    """Return the duration at a squared path velocity b [s]."""
    root = np.sqrt(b)
    return float((2 * grid.step / (root[1:] + root[:-1])).sum())


def duration_gradient(grid: PathGrid, b: Float64[np.ndarray, " n_plus_1"]) -> Array:
    """Return the decrease of the duration per relative increase of b at every grid point [s]."""
    root = np.sqrt(b)
    spent = grid.step / (root[1:] + root[:-1]) ** 2
    return root * (np.append(0.0, spent) + np.append(spent, 0.0))
