"""PathVelocityConstraints: bounds on path velocity besides joint rates, as inequalities in b."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.refine.model.penalty_rows import PenaltyRows

# Penalty of exceeding a limit by its own size, in durations.
RATE_PENALTY = 10.0
# Least coefficient of b in its bounds, so that b stays bounded where nothing moves [s^2].
MIN_COEFFICIENT = 1e-12


@dataclass(frozen=True)
class PathVelocityConstraints:
    """Rows low b_i + high b_{i+1} <= 1 on every interval i of the grid.

    Attributes:
        low: Coefficients of b_i, shape (n, rows).
        high: Coefficients of b_{i+1}, likewise.
    """

    low: Array
    high: Array

    @classmethod
    def of(
        cls,
        step: float,
        u_coefficients: Float64[np.ndarray, "m k"],
        b_coefficients: Float64[np.ndarray, "m k"],
        num_parts: int,
    ) -> "PathVelocityConstraints":
        """Return c_u u + c_b b <= 1 at both ends of every part of every interval.

        Within an interval u is constant and b is linear between its ends.

        Args:
            step: Width of an interval.
            u_coefficients: c_u at the ends of all parts, m = n parts + 1.
            b_coefficients: c_b, likewise.
            num_parts: Number of parts of an interval.
        """
        intervals = np.arange((len(u_coefficients) - 1) // num_parts)
        indices = intervals[:, None] * num_parts + np.arange(num_parts + 1)
        fractions = (np.arange(num_parts + 1) / num_parts)[:, None]
        by_u, by_b = u_coefficients[indices] / (2 * step), b_coefficients[indices]
        low, high = (1 - fractions) * by_b - by_u, fractions * by_b + by_u
        return cls(low.reshape(len(low), -1), high.reshape(len(high), -1))

    @classmethod
    def joined(cls, parts: "list[PathVelocityConstraints]") -> "PathVelocityConstraints":
        """Return the rows of several constraints."""
        lows, highs = [part.low for part in parts], [part.high for part in parts]
        return cls(np.concatenate(lows, axis=1), np.concatenate(highs, axis=1))

    def path_velocity_bounds(self) -> Array:
        """Return bounds on b at every grid point but the ends, from rows in that variable alone."""
        low = np.where(self.high == 0, self.low, 0.0).max(axis=1, initial=0.0)
        high = np.where(self.low == 0, self.high, 0.0).max(axis=1, initial=0.0)
        return 1 / np.maximum(np.maximum(low[1:], high[:-1]), MIN_COEFFICIENT)

    def max_value(self, b: Float64[np.ndarray, " n_plus_1"]) -> float:
        """Return the largest value of a row."""
        values = self.low * b[:-1, None] + self.high * b[1:, None]
        return float(values.max(initial=0.0))

    def rows(self, upper_bounds: Float64[np.ndarray, " n_plus_1"], columns: Indices) -> PenaltyRows:
        """Return the rows that can bind, with b in units of `path_velocity_bounds`.

        Args:
            upper_bounds: Upper bounds of b at the grid.
            columns: Columns of b at both ends of every interval, shape (n, 2).
        """
        values = -np.stack(
            [self.low * upper_bounds[:-1, None], self.high * upper_bounds[1:, None]], axis=-1
        )
        row_columns = np.broadcast_to(columns[:, None], values.shape).reshape(-1, 2)
        values = values.reshape(-1, 2)
        rows = PenaltyRows(row_columns, values, np.full(len(values), -1.0), RATE_PENALTY)
        return rows.selected(np.minimum(values, 0).sum(axis=1) < -1)
