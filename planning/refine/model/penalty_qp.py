"""PenaltyQp: convex quadratic program in a box, with rows under an exact (L1) penalty.

minimize  c . x + 1/2 sum_i q_i x_i^2 + sum_k penalty_k max(0, l_k - a_k . x), lower <= x <= upper

where -|c_k + A_k x| may be in the place of a_k . x. The native kernel has an interior-point solver
for it; without the kernel Clarabel solves it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64
from pydrake.solvers import ClarabelSolver, MathematicalProgram

from planning.domain.arrays import Array
from planning.kernel.native import native
from planning.refine.model.penalty_rows import BallRows, PenaltyRows, ProductRows

# Residuals and gap, relative to the cost, at which the interior-point method ends.
TOLERANCE = 1e-7
MAX_STEPS = 40
_NO_PRODUCTS = np.zeros((0, 0), dtype=np.int64), np.zeros((0, 0)), np.zeros((0, 0))
_NO_BALLS = *[np.zeros(k, dtype=np.int64) for k in (1, 0)], np.zeros(0), np.zeros(0)
# Rows per block: Drake takes dense blocks, which are mostly zeros if they are large.
_BLOCK_SIZE = 64


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
        balls: More rows, few of which bind.
    """

    c: Float64[np.ndarray, " n"]
    q: Float64[np.ndarray, " n"]
    lower: Float64[np.ndarray, " n"]
    upper: Float64[np.ndarray, " n"]
    rows: tuple[PenaltyRows, ...]
    products: ProductRows | None = None
    loads: tuple[PenaltyRows, ...] = ()
    balls: tuple[BallRows, ...] = ()

    def cost(self, x: Float64[np.ndarray, " n"]) -> float:
        """Return the objective at x."""
        smooth_cost = float(self.c @ x + self.q @ (x * x) / 2)
        penalized = *self._expanded_rows, *self.balls
        return smooth_cost + sum(rows.penalty_at(x) for rows in penalized)

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
    def _rows_of_few(self) -> tuple[PenaltyRows | BallRows | ProductRows, ...]:
        products = () if self.products is None else (self.products,)
        return *self.loads, *self.balls, *products

    def _with(self, takes_part: Sequence[Bool[np.ndarray, " m"]]) -> "PenaltyQp":
        """Return the program without the rows of few that do not take part."""
        count, products = len(self.loads), self.products
        loads = zip(self.loads, takes_part, strict=False)
        balls = zip(self.balls, takes_part[count:], strict=False)
        return replace(
            self,
            loads=tuple(rows.selected(takes) for rows, takes in loads),
            balls=tuple(rows.selected(takes) for rows, takes in balls),
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
        of_products, penalized = _NO_PRODUCTS, list[PenaltyRows | ProductRows | BallRows]()
        penalized += self._all_rows
        if self.products is not None:
            products = self.products
            columns = np.ascontiguousarray(products.columns, dtype=np.int64)
            of_products = columns, products.weights, np.ascontiguousarray(products.slopes)
            penalized.append(products)
        penalized += self.balls
        x, _, _ = module.solve_penalty_qp(
            (self.c, self.q, self.lower, self.upper),
            compressed(self._all_rows),
            of_products,
            compressed_balls(self.balls) if self.balls else _NO_BALLS,
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
        for balls in self.balls:
            self._add_balls(program, x, balls)
        return np.array(ClarabelSolver().Solve(program).GetSolution(x))

    def _add_balls(self, program: Any, x: Any, balls: BallRows) -> None:
        """Add cones of lengths up to 1 and a slack that costs."""
        slack: Any = program.NewContinuousVariables(len(balls.centers))
        program.AddLinearCost(np.full(len(slack), balls.penalty), 0.0, slack)
        program.AddBoundingBoxConstraint(0.0, np.inf, slack)
        for k, columns in enumerate(balls.columns):
            taken = columns >= 0
            entries = np.zeros((4, taken.sum() + 1))
            entries[0, -1], entries[1:, :-1] = 1.0, balls.values[k][:, taken]
            variables = np.append(x[columns[taken]], slack[k])
            program.AddLorentzConeConstraint(entries, np.append(1.0, balls.centers[k]), variables)


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


def compressed_balls(balls: Sequence[BallRows]) -> tuple[Any, ...]:
    """Return balls as the kernel takes them: starts, columns, values and centers."""
    masks = [part.columns >= 0 for part in balls]
    counts = np.concatenate([mask.sum(axis=1) for mask in masks])
    values = [
        component[mask_of_ball]
        for part, mask in zip(balls, masks, strict=True)
        for of_ball, mask_of_ball in zip(part.values, mask, strict=True)
        for component in of_ball
    ]
    pairs = list(zip(balls, masks, strict=True))
    return (
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        np.concatenate([part.columns[mask] for part, mask in pairs]).astype(np.int64),
        np.concatenate([np.zeros(0), *values]),
        np.concatenate([part.centers.ravel() for part in balls]),
    )


def bounds_of(rows: Sequence[PenaltyRows | ProductRows | BallRows]) -> tuple[Array, Array]:
    """Return the lower bounds and penalties of rows."""
    penalties = [np.full(len(part.lower_bounds), part.penalty) for part in rows]
    return np.concatenate([part.lower_bounds for part in rows]), np.concatenate(penalties)


def solver_name() -> str:
    """Return the name of the solver in use."""
    return "Clarabel" if native() is None else "interior point"
