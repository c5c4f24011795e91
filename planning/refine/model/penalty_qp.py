"""PenaltyQp: convex quadratic program in a box, with linear rows under an exact (L1) penalty.

minimise  c . x + 1/2 sum_i q_i x_i^2 + sum_k price_k max(0, least_k - a_k . x), lower <= x <= upper

The native kernel has an interior-point solver for it; without the kernel Clarabel solves it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64, Int
from pydrake.solvers import ClarabelSolver, MathematicalProgram

from planning.kernel.native import native

type Array = np.ndarray[Any, np.dtype[np.float64]]

_TOLERANCE = 1e-7
_MAX_STEPS = 40
# Rows per block: Drake takes dense blocks, which are mostly zeros if they are large.
_AT_ONCE = 64


@dataclass(frozen=True)
class PenaltyRows:
    """Rows a_k . x >= least_k, all with the same number of entries.

    Attributes:
        columns: Of the entries; -1 for none, shape (m, entries).
        values: Shape (m, entries).
        least: Shape (m,).
        price: Penalty per unit of violation, for each row.
    """

    columns: Int[np.ndarray, "m entries"]
    values: Float64[np.ndarray, "m entries"]
    least: Float64[np.ndarray, " m"]
    price: float

    @classmethod
    def between(
        cls,
        columns: Int[np.ndarray, "*m entries"],
        values: Float64[np.ndarray, "*m entries"],
        now: Float64[np.ndarray, " *m"],
        bounds: Float64[np.ndarray, "2 ..."],
        price: float,
    ) -> "PenaltyRows":
        """Return rows that keep now + values . x between two bounds, a pair for each.

        The rows are in units of the bounds, the first of which is negative and the second positive;
        the other axes of `bounds` are those of `now`, or have length 1.
        """
        low, high = bounds
        entries = columns.shape[-1]
        pairs = np.stack([-values / high[..., None], -values / low[..., None]], axis=-2)
        twice = np.repeat(columns.reshape(-1, entries), 2, axis=0)
        least = np.stack([now / high - 1, now / low - 1], axis=-1)
        return cls(twice, pairs.reshape(-1, entries), least.ravel(), price)

    @classmethod
    def stacked(cls, parts: "list[PenaltyRows]") -> "PenaltyRows":
        """Return the rows of several parts of equal price."""
        columns, values, least = (
            np.concatenate(arrays)
            for arrays in zip(*((p.columns, p.values, p.least) for p in parts), strict=True)
        )
        return cls(columns, values, least, parts[0].price)

    def taken(self, which: Any) -> "PenaltyRows":
        """Return the selected rows."""
        return PenaltyRows(self.columns[which], self.values[which], self.least[which], self.price)

    def cost(self, x: Float64[np.ndarray, " n"]) -> float:
        """Return the penalty at x."""
        return self.price * float(np.maximum(self.lacks(x), 0.0).sum())

    def lacks(self, x: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " m"]:
        """Return the violation of each row at x, negative where it is satisfied with a margin."""
        return self.least - (self.values * np.append(x, 0.0)[self.columns]).sum(axis=1)


@dataclass(frozen=True)
class PenaltyQp:
    """Penalty QP of the module's docstring; c, q, lower and upper have shape (n,)."""

    c: Float64[np.ndarray, " n"]
    q: Float64[np.ndarray, " n"]
    lower: Float64[np.ndarray, " n"]
    upper: Float64[np.ndarray, " n"]
    rows: tuple[PenaltyRows, ...]

    def cost(self, x: Float64[np.ndarray, " n"]) -> float:
        """Return the objective at x."""
        own = float(self.c @ x + self.q @ (x * x) / 2)
        return own + sum(rows.cost(x) for rows in self.rows)

    def solve(self, *, natively: bool = True) -> Array:
        """Return the minimiser, shape (n,)."""
        columns = [rows.columns >= 0 for rows in self.rows]
        counts = np.concatenate([held.sum(axis=1) for held in columns])
        starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        entries = np.concatenate([r.columns[h] for r, h in zip(self.rows, columns, strict=True)])
        values = np.concatenate([r.values[h] for r, h in zip(self.rows, columns, strict=True)])
        least = np.concatenate([rows.least for rows in self.rows])
        price = np.concatenate([np.full(len(rows.least), rows.price) for rows in self.rows])
        module: Any = native() if natively else None
        if module is None:
            return self._by_clarabel(starts, entries, values, least, price)
        x, _, _ = module.solve_penalty_qp(
            (self.c, self.q, self.lower, self.upper),
            (starts, entries.astype(np.int64), values),
            least,
            price,
            _TOLERANCE,
            _MAX_STEPS,
        )
        return x

    def _by_clarabel(
        self, starts: Any, entries: Any, values: Array, least: Array, price: Array
    ) -> Array:
        matrix = np.zeros((len(least), len(self.c)))
        matrix[np.repeat(np.arange(len(least)), np.diff(starts)), entries] = values
        program = MathematicalProgram()
        x: Any = program.NewContinuousVariables(len(self.c))
        lack: Any = program.NewContinuousVariables(len(least))
        program.AddQuadraticCost(np.diag(self.q), self.c, x, is_convex=True)
        program.AddLinearCost(price, 0.0, lack)
        program.AddBoundingBoxConstraint(self.lower, self.upper, x)
        program.AddBoundingBoxConstraint(0.0, np.inf, lack)
        for begin in range(0, len(least), _AT_ONCE):
            some = slice(begin, begin + _AT_ONCE)
            both = np.hstack([matrix[some], np.eye(len(least[some]))])
            most = np.full(len(least[some]), np.inf)
            program.AddLinearConstraint(both, least[some], most, np.concatenate([x, lack[some]]))
        return np.array(ClarabelSolver().Solve(program).GetSolution(x))


def solver_name() -> str:
    """Return the name of the solver in use."""
    return "Clarabel" if native() is None else "interior point"
