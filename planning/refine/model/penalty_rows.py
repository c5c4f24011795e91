"""Rows of a penalty QP: linear ones, products of weights and slopes, and vectors in unit balls."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int

# Share of the largest change of a row that minimizers rarely exceed, and the change of a load over
# its bound that they rarely exceed.
_LIKELY_SHARE, _LIKELY_CHANGE = 0.25, 0.6


@dataclass(frozen=True)
class PenaltyRows:
    """Rows a_k . x >= l_k, all with the same number of entries.

    Attributes:
        columns: Columns of the entries of a_k; -1 for none, shape (m, entries).
        values: The entries, shape (m, entries).
        lower_bounds: l_k, shape (m,).
        penalty: Penalty per unit of violation, for each row.
    """

    columns: Int[np.ndarray, "m entries"]
    values: Float64[np.ndarray, "m entries"]
    lower_bounds: Float64[np.ndarray, " m"]
    penalty: float

    @classmethod
    def between(
        cls,
        columns: Int[np.ndarray, "*m entries"],
        values: Float64[np.ndarray, "*m entries"],
        current: Float64[np.ndarray, " *m"],
        bounds: Float64[np.ndarray, "2 ..."],
        penalty: float,
    ) -> "PenaltyRows":
        """Return rows that keep current + values . x between two bounds, a pair for each.

        The rows are in units of the bounds, the first of which is negative and the second positive;
        the other axes of `bounds` are those of `current`, or have length 1.
        """
        low, high = bounds
        entries = columns.shape[-1]
        pairs = np.stack([-values / high[..., None], -values / low[..., None]], axis=-2)
        repeated_columns = np.repeat(columns.reshape(-1, entries), 2, axis=0)
        lower_bounds = np.stack([current / high - 1, current / low - 1], axis=-1)
        return cls(repeated_columns, pairs.reshape(-1, entries), lower_bounds.ravel(), penalty)

    def selected(self, which: Any) -> "PenaltyRows":
        """Return the selected rows."""
        return PenaltyRows(
            self.columns[which], self.values[which], self.lower_bounds[which], self.penalty
        )

    @property
    def are_likely(self) -> Bool[np.ndarray, " m"]:
        """Whether the minimizer in a box of -1 to 1 is likely to break each row without it."""
        largest_changes = np.abs(np.where(self.columns >= 0, self.values, 0.0)).sum(axis=1)
        return -self.lower_bounds < np.minimum(_LIKELY_SHARE * largest_changes, _LIKELY_CHANGE)

    def penalty_at(self, x: Float64[np.ndarray, " n"]) -> float:
        """Return the penalty at x."""
        return self.penalty * float(np.maximum(self.violations(x), 0.0).sum())

    def violations(self, x: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " m"]:
        """Return the violation of each row at x, negative where it is satisfied with a margin."""
        if not x.any():
            return self.lower_bounds
        return self.lower_bounds - (self.values * np.append(x, 0.0)[self.columns]).sum(axis=1)


@dataclass(frozen=True)
class ProductRows:
    """Rows a_k . x >= l_k whose entries are products: a_k = sum_ij weights_ki slopes_kj e_kij.

    e_kij is the unit vector of column columns_ki + j, or 0 if columns_ki is -1.

    Attributes:
        columns: First columns of the entries of each weight, shape (m, points).
        weights: Shape (m, points).
        slopes: Shape (m, coordinates).
        lower_bounds: l_k, shape (m,).
        penalty: Penalty per unit of violation, for each row.
    """

    columns: Int[np.ndarray, "m points"]
    weights: Float64[np.ndarray, "m points"]
    slopes: Float64[np.ndarray, "m coordinates"]
    lower_bounds: Float64[np.ndarray, " m"]
    penalty: float

    @cached_property
    def expanded(self) -> PenaltyRows:
        """The same rows with all their entries."""
        columns = self.columns[:, :, None] + np.arange(self.slopes.shape[1])
        columns[self.columns < 0] = -1
        values = self.weights[:, :, None] * self.slopes[:, None]
        size = len(values), values.shape[1] * values.shape[2]
        return PenaltyRows(
            columns.reshape(size), values.reshape(size), self.lower_bounds, self.penalty
        )

    def violations(self, x: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " m"]:
        """Return the violation of each row at x, negative where it is satisfied with a margin."""
        return self.expanded.violations(x)

    @property
    def are_likely(self) -> Bool[np.ndarray, " m"]:
        """Whether the minimizer in a box of -1 to 1 is likely to break each row without it."""
        return -self.lower_bounds < _LIKELY_SHARE * np.abs(self.slopes).sum(axis=1)

    def selected(self, which: Any) -> "ProductRows":
        """Return the selected rows."""
        return ProductRows(
            self.columns[which],
            self.weights[which],
            self.slopes[which],
            self.lower_bounds[which],
            self.penalty,
        )


@dataclass(frozen=True)
class BallRows:
    """Vectors c_k + A_k x that are to stay in the unit ball, all with the same number of entries.

    Attributes:
        columns: Columns of the entries of A_k, which its rows share; -1 for none, shape (m,
            entries).
        values: The entries, shape (m, 3, entries).
        centers: c_k, shape (m, 3).
        penalty: Penalty per unit of length beyond 1, for each ball.
    """

    columns: Int[np.ndarray, "m entries"]
    values: Float64[np.ndarray, "m 3 entries"]
    centers: Float64[np.ndarray, "m 3"]
    penalty: float

    @property
    def lower_bounds(self) -> Float64[np.ndarray, " m"]:
        """Least of minus the lengths."""
        return np.full(len(self.centers), -1.0)

    def selected(self, which: Any) -> "BallRows":
        """Return the selected balls."""
        return BallRows(self.columns[which], self.values[which], self.centers[which], self.penalty)

    @property
    def are_likely(self) -> Bool[np.ndarray, " m"]:
        """Whether the minimizer in a box of -1 to 1 is likely to leave each ball without it."""
        lengths = np.linalg.norm(self.centers, axis=1)
        units = self.centers / np.where(lengths > 0, lengths, 1.0)[:, None]
        values = np.where(self.columns[:, None] >= 0, self.values, 0.0)
        largest_changes = np.abs(np.einsum("md,mde->me", units, values)).sum(axis=1)
        return 1 - lengths < np.minimum(_LIKELY_SHARE * largest_changes, _LIKELY_CHANGE)

    def penalty_at(self, x: Float64[np.ndarray, " n"]) -> float:
        """Return the penalty at x."""
        return self.penalty * float(np.maximum(self.violations(x), 0.0).sum())

    def violations(self, x: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " m"]:
        """Return by how much each vector's length is above 1 at x, negative where it is below."""
        changes = np.einsum("mde,me->md", self.values, np.append(x, 0.0)[self.columns])
        return np.linalg.norm(self.centers + changes, axis=1) - 1
