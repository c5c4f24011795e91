"""PenaltyQp: convex quadratic program in a box, with linear rows under an exact (L1) penalty.

minimize  c . x + 1/2 sum_i q_i x_i^2 + sum_k penalty_k max(0, l_k - a_k . x), lower <= x <= upper

The native kernel has an interior-point solver for it; without the kernel Clarabel solves it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int
from pydrake.solvers import ClarabelSolver, MathematicalProgram

from planning.domain.arrays import Array
from planning.kernel.native import native

# Residuals and gap, relative to the cost, at which the interior-point method ends.
TOLERANCE = 1e-7
MAX_STEPS = 40
_NO_PRODUCTS = np.zeros((0, 0), dtype=np.int64), np.zeros((0, 0)), np.zeros((0, 0))
# Rows per block: Drake takes dense blocks, which are mostly zeros if they are large.
_BLOCK_SIZE = 64
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
class PenaltyQp:
    """Penalty QP of the module's docstring; c, q, lower and upper have shape (n,).

    Attributes:
        c: Linear cost.
        q: Diagonal of the quadratic cost.
        lower: Lower bounds.
        upper: Upper bounds.
        rows: Rows that always take part.
        products: More rows, few of which bind.
        loads: More rows, few of which bind.
    """

    c: Float64[np.ndarray, " n"]
    q: Float64[np.ndarray, " n"]
    lower: Float64[np.ndarray, " n"]
    upper: Float64[np.ndarray, " n"]
    rows: tuple[PenaltyRows, ...]
    products: ProductRows | None = None
    loads: tuple[PenaltyRows, ...] = ()

    def cost(self, x: Float64[np.ndarray, " n"]) -> float:
        """Return the objective at x."""
        smooth_cost = float(self.c @ x + self.q @ (x * x) / 2)
        return smooth_cost + sum(rows.penalty_at(x) for rows in self._expanded_rows)

    def solve_by_active_rows(self) -> Array:
        """Return the minimizer, shape (n,), by programs of those rows of few that are broken.

        A row that the minimizer without it does not break costs nothing there: without all such
        rows the minimizer is the same. The box is to be that of -1 to 1, in which a row is likely
        to be broken if a share of the largest change of a_k . x would break it.
        """
        takes_part = [rows.are_likely for rows in self._rows_of_few]
        while True:
            x = self._with(takes_part).solve()
            are_broken = [
                ~takes & (rows.violations(x) > 0)
                for takes, rows in zip(takes_part, self._rows_of_few, strict=True)
            ]
            if not any(broken.any() for broken in are_broken):
                return x
            pairs = zip(takes_part, are_broken, strict=True)
            takes_part = [takes | broken for takes, broken in pairs]

    @property
    def _rows_of_few(self) -> tuple[PenaltyRows | ProductRows, ...]:
        return self.loads if self.products is None else (*self.loads, self.products)

    def _with(self, takes_part: Sequence[Bool[np.ndarray, " m"]]) -> "PenaltyQp":
        """Return the program without the rows of few that do not take part."""
        loads = zip(self.loads, takes_part, strict=False)
        products = self.products
        return replace(
            self,
            loads=tuple(rows.selected(takes) for rows, takes in loads),
            products=None if products is None else products.selected(takes_part[-1]),
        )

    @property
    def _expanded_rows(self) -> tuple[PenaltyRows, ...]:
        rows = self._all_rows
        return rows if self.products is None else (*rows, self.products.expanded)

    @property
    def _all_rows(self) -> tuple[PenaltyRows, ...]:
        return (*self.rows, *self.loads)

    def solve(self, *, use_kernel: bool = True) -> Array:
        """Return the minimizer, shape (n,)."""
        module: Any = native() if use_kernel else None
        if module is None:
            return self._solve_with_clarabel()
        of_products, penalized = _NO_PRODUCTS, list[PenaltyRows | ProductRows](self._all_rows)
        if self.products is not None:
            products = self.products
            columns = np.ascontiguousarray(products.columns, dtype=np.int64)
            of_products = columns, products.weights, np.ascontiguousarray(products.slopes)
            penalized.append(products)
        x, _, _ = module.solve_penalty_qp(
            (self.c, self.q, self.lower, self.upper),
            compressed(self._all_rows),
            of_products,
            *bounds_of(penalized),
            TOLERANCE,
            MAX_STEPS,
        )
        return x

    def _solve_with_clarabel(self) -> Array:
        starts, entries, values = compressed(self._expanded_rows)
        lower_bounds, penalties = bounds_of(self._expanded_rows)
        matrix = np.zeros((len(lower_bounds), len(self.c)))
        matrix[np.repeat(np.arange(len(lower_bounds)), np.diff(starts)), entries] = values
        program = MathematicalProgram()
        x: Any = program.NewContinuousVariables(len(self.c))
        slack: Any = program.NewContinuousVariables(len(lower_bounds))
        program.AddQuadraticCost(np.diag(self.q), self.c, x, is_convex=True)
        program.AddLinearCost(penalties, 0.0, slack)
        program.AddBoundingBoxConstraint(self.lower, self.upper, x)
        program.AddBoundingBoxConstraint(0.0, np.inf, slack)
        for begin in range(0, len(lower_bounds), _BLOCK_SIZE):
            block = slice(begin, begin + _BLOCK_SIZE)
            coefficients = np.hstack([matrix[block], np.eye(len(lower_bounds[block]))])
            upper_bounds = np.full(len(lower_bounds[block]), np.inf)
            program.AddLinearConstraint(
                coefficients, lower_bounds[block], upper_bounds, np.concatenate([x, slack[block]])
            )
        return np.array(ClarabelSolver().Solve(program).GetSolution(x))


def compressed(rows: Sequence[PenaltyRows]) -> tuple[Any, Any, Array]:
    """Return rows as compressed sparse rows: starts, columns and values."""
    masks = [part.columns >= 0 for part in rows]
    counts = np.concatenate([mask.sum(axis=1) for mask in masks])
    masked = list(zip(rows, masks, strict=True))
    return (
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        np.concatenate([part.columns[mask] for part, mask in masked]).astype(np.int64),
        np.concatenate([part.values[mask] for part, mask in masked]),
    )


def bounds_of(rows: Sequence[PenaltyRows | ProductRows]) -> tuple[Array, Array]:
    """Return the lower bounds and penalties of rows."""
    penalties = [np.full(len(part.lower_bounds), part.penalty) for part in rows]
    return np.concatenate([part.lower_bounds for part in rows]), np.concatenate(penalties)


def solver_name() -> str:
    """Return the name of the solver in use."""
    return "Clarabel" if native() is None else "interior point"
