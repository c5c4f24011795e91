"""Curves in the native kernel: the grid of their derivatives, and their minimum-time path velocity.

The same as `minimum_time_path_velocity` in numpy, which is the reference, and what runs without the
kernel. Rows that bind nowhere are left out first, so that the kernel's linear program is small.
"""

from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.kernel.native import native
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.curves.path_velocity import path_grid
from planning.refine.model.path_velocity_constraints import PathVelocityConstraints
from planning.refine.model.penalty_qp import MAX_STEPS, TOLERANCE

_NO_NUMBERS = np.zeros(0)


@lru_cache(maxsize=8)
def native_grid(num_control_points: int) -> Any:
    """Return the kernel's grid for a number of control points, or None without the kernel."""
    module: Any = native()
    if module is None:
        return None
    grid = path_grid(num_control_points)
    first_points = np.ascontiguousarray(grid.control_points[:, 0], dtype=np.int64)
    derivatives = (np.ascontiguousarray(w) for w in (grid.first, grid.second, grid.third))
    return module.CurveGrid(first_points, num_control_points, *derivatives, grid.step)


def native_path_velocity(
    points: Float64[np.ndarray, "k nq"],
    bounds: RateBounds,
    load_constraints: PathVelocityConstraints | None,
) -> Array | None:
    """Return the largest admissible squared path velocity b [1/s^2] at the grid.

    None without the kernel.
    """
    grid: Any = native_grid(len(points))
    if grid is None:
        return None
    empty = np.zeros((len(path_grid(len(points)).control_points), 0))
    low, high = (
        (empty, empty)
        if load_constraints is None
        else (
            np.ascontiguousarray(load_constraints.low),
            np.ascontiguousarray(load_constraints.high),
        )
    )
    b, _ = grid.path_velocity(
        kernel_bounds(bounds), np.ascontiguousarray(points), low, high, TOLERANCE, MAX_STEPS
    )
    return b


def kernel_bounds(bounds: RateBounds) -> tuple[Array, Array, Array, Array]:
    """Return bounds on rates as the kernel takes them."""
    jerk = _NO_NUMBERS if bounds.jerk is None else np.array(bounds.jerk)
    return (
        np.array(bounds.velocity),
        np.array(bounds.acceleration),
        jerk,
        np.array(bounds.acceleration_range),
    )
