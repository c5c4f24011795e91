"""TOPP-RA passes: backward and forward pass over cells of a path, with toppra's LP solver.

Pham and Pham, "A new approach to time-optimal path parameterization based on reachability
analysis", T-RO 2018. The backward pass computes the controllable sets of squared speeds; the
forward pass takes the greatest of them. Rest is always controllable, because the limits are
symmetric: the sets begin at zero, and half of toppra's own linear programs need not be solved.
toppra's own class has more overhead around every program; only its solver is used here, and where
there is a kernel, its twin in `planning/kernel/src/path`, which has the same numbers.
"""

from math import isfinite, isnan
from typing import Any, override

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.errors import RetimingFailed
from planning.kernel.native import native
from planning.retime.toppra.toppra_solver import (
    ConstraintType,
    DiscretizationType,
    LinearConstraint,
    seidelWrapper,
)

# As in toppra: a reached speed is lowered by this, so that it stays controllable in spite of
# rounding; if it is not, it is lowered further, this number of times.
_SPEED_REDUCTION = 1e-8
_MAX_TRIES = 10
_UNSPECIFIED = float("nan")


def squared_speeds(
    edges: Float64[np.ndarray, " n_plus_1"],
    rows: tuple[Float64[np.ndarray, "n m"], Float64[np.ndarray, "n m"]],
    caps: Float64[np.ndarray, " n_plus_1"],
) -> Float64[np.ndarray, " n_plus_1"]:
    """Return the greatest x = (ds/dt)^2 at the edges of the cells, from rest to rest.

    Args:
        edges: Path parameter, increasing.
        rows: a and b of the limits a u + b x <= 1 on every cell, u = d2s/dt2, x at its beginning.
            They must allow u = 0 at x = 0. Numbers should be of order one.
        caps: Upper bounds on x at the edges.

    Raises:
        RetimingFailed: toppra finds none.
    """
    module = native()
    # Numbers that are not finite are left to toppra, and so is to say that there is no profile.
    if module is not None and isfinite(float(rows[0].sum() + rows[1].sum())):
        x = module.squared_speeds(
            edges, np.ascontiguousarray(rows[0]), np.ascontiguousarray(rows[1]), caps
        )
        if len(x):
            return np.asarray(x)
    return speeds_by_toppra(edges, rows, caps)


def speeds_by_toppra(
    edges: Float64[np.ndarray, " n_plus_1"],
    rows: tuple[Float64[np.ndarray, "n m"], Float64[np.ndarray, "n m"]],
    caps: Float64[np.ndarray, " n_plus_1"],
) -> Float64[np.ndarray, " n_plus_1"]:
    """Return the same by toppra's own solver, with which the kernel's passes agree bit by bit.

    Raises:
        RetimingFailed: toppra finds none.
    """
    solver = seidelWrapper([_RowConstraint(rows, caps)], None, edges, solve_lp1d=True)
    steps = (2 * np.diff(edges)).tolist()
    controllable = _controllable_speeds(solver, len(steps))
    # A sum is finite only if all terms are: toppra's solver returns NaN if there is no solution.
    x = (
        np.array(_forward_pass(solver, steps, controllable))
        if isfinite(sum(controllable))
        else np.array(_UNSPECIFIED)
    )
    if not np.isfinite(x).all():
        message = "toppra found no velocity profile along the path"
        raise RetimingFailed(message, {"method": "toppra", "num_grid_points": len(edges)})
    return x


def _controllable_speeds(solver: Any, count: int) -> list[float]:
    """Return the greatest controllable x at every edge (backward pass)."""
    solve = solver.solve_stagewise_optim
    # Greatest x; among equals, the smallest u.
    objective = np.array([1e-9, -1.0])
    controllable = [0.0] * (count + 1)
    for i in reversed(range(count)):
        controllable[i] = solve(
            i, None, objective, _UNSPECIFIED, _UNSPECIFIED, 0.0, controllable[i + 1]
        )[1]
    return controllable


def _forward_pass(solver: Any, steps: list[float], controllable: list[float]) -> list[float]:
    """Return the greatest x at every edge, from rest on (forward pass)."""
    solve = solver.solve_stagewise_optim
    objective = np.array([0.0, -1.0])
    x = [0.0] * len(controllable)
    for i, step in enumerate(steps):
        objective[0] = -step
        current, upper_bound, u, tries = x[i], controllable[i + 1], _UNSPECIFIED, _MAX_TRIES
        while isnan(u) and tries:
            u = solve(i, None, objective, current, current, 0.0, upper_bound)[0]
            if isnan(u):
                current, tries = max(current - _SPEED_REDUCTION, 0.999 * current), tries - 1
        x[i] = current
        following = current + step * u
        x[i + 1] = min(max(following - _SPEED_REDUCTION, 0.9999 * following, 0.0), upper_bound)
    return x


class _RowConstraint(LinearConstraint):
    """Constraint rows in toppra's format."""

    def __init__(self, rows: tuple[Array, Array], caps: Array) -> None:
        super().__init__()
        self.constraint_type = ConstraintType.CanonicalLinear
        self.discretization_type = DiscretizationType.Collocation
        self.identical = True
        self._rows = rows
        self._caps = caps

    @override
    def compute_constraint_params(
        self, path: Any, gridpoints: Array, *args: Any, **kwargs: Any
    ) -> tuple[Any, ...]:
        # toppra needs rows for the last grid point as well, though no cell follows it.
        a, b = (np.concatenate([part, part[-1:]]) for part in self._rows)
        count = a.shape[1]
        bounds = np.stack([np.zeros_like(self._caps), self._caps], axis=1)
        return a, b, np.zeros_like(a), np.eye(count), np.ones(count), None, bounds
