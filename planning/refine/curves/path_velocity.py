"""Minimum-time path velocity of a curve, rest to rest: b = (ds/dt)^2 [1/s^2] at points of a grid.

On each interval of the grid d2s/dt2 is constant, u_i = (b_{i+1} - b_i) / (2 h). At both ends of
every interval velocity r' sqrt(b) and acceleration r'' b + r' u are bounded: time-optimal path
parametrization (Verscheure et al., "Time-optimal path tracking for robots", 2009), which the
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
from planning.refine.curves.bspline_basis import basis_weights, num_spans
from planning.refine.model.path_velocity_constraints import (
    MIN_COEFFICIENT,
    RATE_PENALTY,
    PathVelocityConstraints,
)
from planning.refine.model.penalty_qp import PenaltyQp
from planning.refine.model.penalty_rows import PenaltyRows

_INTERVALS_PER_SPAN = 4
# Number of rows above which the solver begins with a subset of them, and that subset's stride.
_MANY_ROWS, _ROW_STRIDE = 1500, 6
# Violation above which a row counts as broken, as a share of its bound.
_ROW_TOLERANCE = 1e-6
# Least b as a share of its upper bound, so that the motion stops nowhere between its ends.
_MIN_RELATIVE_VELOCITY = 1e-9


@dataclass(frozen=True)
class PathGrid:
    """Grid of n intervals, each within a span of knots, with weights of derivatives at their ends.

    Attributes:
        step: Width of an interval.
        control_points: Indices of the control points with nonzero weight on each interval, shape
            (n, 4).
        first: Weights of r' at both ends of each, shape (n, 2, 4).
        second: Weights of r'', likewise.
        third: Weights of r''', shape (n, 4).
    """

    step: float
    control_points: Indices
    first: Array
    second: Array
    third: Array


@lru_cache(maxsize=8)
def path_grid(num_control_points: int) -> PathGrid:
    """Return the grid for a number of control points."""
    num_intervals = num_spans(num_control_points) * _INTERVALS_PER_SPAN
    spans = np.arange(num_intervals) // _INTERVALS_PER_SPAN
    low = np.arange(num_intervals) / num_intervals
    high = np.arange(1, num_intervals + 1) / num_intervals
    first, second = (
        np.stack(
            [basis_weights(num_control_points, s, order, spans).values for s in (low, high)], axis=1
        )
        for order in (1, 2)
    )
    third = basis_weights(num_control_points, (low + high) / 2, 3, spans)
    return PathGrid(1 / num_intervals, third.control_points, first, second, third.values)


@dataclass(frozen=True)
class NormalizedDerivatives:
    """Derivatives of a curve by s, over the bounds on rates.

    Attributes:
        first_by_velocity: r' over velocity, shape (n, 2, nq).
        first_by_acceleration: r' over acceleration, likewise.
        second_by_acceleration: r'' over acceleration, likewise.
        third_by_jerk: r''' over jerk, or zero, shape (n, nq).
        acceleration_range: Lowest and highest of what `accelerations` returns, shape (2, nq).
    """

    first_by_velocity: Array
    first_by_acceleration: Array
    second_by_acceleration: Array
    third_by_jerk: Array
    acceleration_range: Array

    @classmethod
    def of(
        cls, grid: PathGrid, points: Float64[np.ndarray, "k nq"], bounds: RateBounds
    ) -> "NormalizedDerivatives":
        """Return the derivatives of the curve with these control points."""
        control_points = points[grid.control_points]
        first, second = grid.first @ control_points, grid.second @ control_points
        third = np.zeros_like(first[:, 0])
        if bounds.jerk is not None:
            third = np.einsum("nk,nkj->nj", grid.third, control_points) / bounds.jerk
        return cls(
            first / bounds.velocity,
            first / bounds.acceleration,
            second / bounds.acceleration,
            third,
            bounds.acceleration_range,
        )

    def path_velocity_bounds(self) -> Array:
        """Return bounds on b from velocity and jerk at every grid point but the ends [1/s^2]."""
        velocity_peaks = np.abs(self.first_by_velocity[1:, 0]).max(axis=1)
        jerk_peaks = np.abs(self.third_by_jerk).max(axis=1)
        adjacent_jerk_peaks = np.maximum(jerk_peaks[1:], jerk_peaks[:-1])
        return 1 / np.maximum(
            np.maximum(velocity_peaks**2, adjacent_jerk_peaks ** (2 / 3)), MIN_COEFFICIENT
        )

    def accelerations(self, grid: PathGrid, b: Float64[np.ndarray, " n_plus_1"]) -> Array:
        """Return acceleration over the larger of its bounds, shape (n, 2, nq)."""
        u = np.diff(b) / (2 * grid.step)
        return (
            self.second_by_acceleration * both_ends(b)[..., None]
            + self.first_by_acceleration * u[:, None, None]
        )

    def max_acceleration_ratio(self, grid: PathGrid, b: Float64[np.ndarray, " n_plus_1"]) -> float:
        """Return the largest acceleration over the bound of its sign, 1 at the bound."""
        return float((self.accelerations(grid, b)[..., None, :] / self.acceleration_range).max())

    def acceleration_gradients(self, grid: PathGrid) -> tuple[Array, Array]:
        """Return the derivatives of accelerations by b at the low and high ends of intervals."""
        a = self.first_by_acceleration / (2 * grid.step)
        at_low, at_high = -a, a.copy()
        at_low[:, 0] += self.second_by_acceleration[:, 0]
        at_high[:, 1] += self.second_by_acceleration[:, 1]
        return at_low, at_high


def both_ends(b: Any) -> Any:
    """Return values at grid points for both ends of every interval, shape (n, 2)."""
    return np.stack([b[:-1], b[1:]], axis=1)


def minimum_time_path_velocity(
    grid: PathGrid,
    derivatives: NormalizedDerivatives,
    load_constraints: PathVelocityConstraints | None = None,
) -> Float64[np.ndarray, " n_plus_1"]:
    """Return the largest admissible squared path velocity b [1/s^2] at the grid.

    It is the largest at every grid point at once (Pham and Pham, "A new approach to time-optimal
    path parameterization based on reachability analysis", 2018), so that maximizing a sum gives it.
    """
    num_intervals = len(grid.control_points)
    inner_bounds = derivatives.path_velocity_bounds()
    if load_constraints is not None:
        inner_bounds = np.minimum(inner_bounds, load_constraints.path_velocity_bounds())
    upper_bounds = np.concatenate([[0.0], inner_bounds, [0.0]])
    at_low, at_high = derivatives.acceleration_gradients(grid)
    values = np.stack(
        [at_low * upper_bounds[:-1, None, None], at_high * upper_bounds[1:, None, None]], axis=-1
    ).transpose(0, 2, 1, 3)
    variable_indices = np.concatenate([[-1], np.arange(num_intervals - 1), [-1]])
    columns = np.broadcast_to(both_ends(variable_indices)[:, None, None], values.shape)
    zeros = np.zeros(values.shape[:-1])
    rows = PenaltyRows.between(
        columns, values, zeros, derivatives.acceleration_range[:, None, :, None], RATE_PENALTY
    )
    rows = rows.selected(np.minimum(rows.values, 0).sum(axis=1) < -1)
    extra = (
        None
        if load_constraints is None
        else load_constraints.rows(upper_bounds, both_ends(variable_indices))
    )
    b = np.zeros(num_intervals + 1)
    b[1:-1] = (
        np.clip(_maximize(num_intervals - 1, rows, extra), _MIN_RELATIVE_VELOCITY, 1.0)
        * upper_bounds[1:-1]
    )
    # The solver satisfies rows to its tolerance; b as a whole is divided by the largest ratio.
    max_ratio = derivatives.max_acceleration_ratio(grid, b)
    if load_constraints is not None:
        max_ratio = max(max_ratio, load_constraints.max_value(b))
    return b / max(1.0, max_ratio)


def _maximize(num_variables: int, rows: PenaltyRows, extra: PenaltyRows | None) -> Array:
    """Return the largest x in [0, 1]^num_variables that satisfies rows, near 1 if none binds.

    Most rows of a large `extra` bind nowhere: a subset is used at first, then violated rows are
    added.
    """
    objective_and_box = (
        np.full(num_variables, -1 / num_variables),
        np.zeros(num_variables),
        np.zeros(num_variables),
        np.ones(num_variables),
    )
    if extra is None:
        return PenaltyQp(*objective_and_box, (rows,)).solve()
    is_included = np.full(len(extra.lower_bounds), len(extra.lower_bounds) < _MANY_ROWS)
    is_included[::_ROW_STRIDE] = True
    while True:
        x = PenaltyQp(*objective_and_box, (rows, extra.selected(is_included))).solve()
        is_violated = extra.violations(x) > _ROW_TOLERANCE
        if not (is_violated & ~is_included).any():
            return x
        is_included |= is_violated


def duration_of(grid: PathGrid, b: Float64[np.ndarray, " n_plus_1"]) -> float:
    """Return the duration at a squared path velocity b [s]."""
    root = np.sqrt(b)
    return float((2 * grid.step / (root[1:] + root[:-1])).sum())


def duration_gradient(grid: PathGrid, b: Float64[np.ndarray, " n_plus_1"]) -> Array:
    """Return the decrease of the duration per relative increase of b at every grid point [s]."""
    root = np.sqrt(b)
    interval_times = grid.step / (root[1:] + root[:-1]) ** 2
    return root * (np.append(0.0, interval_times) + np.append(interval_times, 0.0))
