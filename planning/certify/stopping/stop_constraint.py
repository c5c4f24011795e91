"""StopConstraint: a limit on a quantity that depends on how a motion is slowed down.

For a motion followed with s' and s'', let y = s'^2, r = s' and x = -s''. The constraint is

    |a y + b r + c - d x| <= bound,

whose four coefficients are polynomials on every cell: a is `by_squared_path_velocity`, b is
`by_path_velocity`, c is `constant` and d is `by_path_acceleration`. For accelerations a and d are
the second derivative and the first, and c is minus the middle of bounds that differ by sign; for
torques c is gravity, and b is damping.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices


@dataclass(frozen=True)
class StopConstraint:
    """Constraints on blocks with the same number of coordinates, in n cells.

    Coefficients are in Bernstein form, or values at instants between which the quantity is linear:
    a convex bound that holds for all of them holds on the whole cell.

    Attributes:
        names: Names of the blocks.
        by_path_acceleration: Coefficients of -x, shape (n, k, blocks, size).
        by_squared_path_velocity: Coefficients of y, same shape.
        constant: Constant term, same shape or one that broadcasts to it.
        by_path_velocity: Coefficients of r, same shape; None for zero.
        path_acceleration_error: Bound on the error of `by_path_acceleration`, shape (n, blocks).
        bounds: Bound on the norm, minus the errors of all other coefficients for y and r up to 1;
            negative where the coefficients are unknown. Shape (n, blocks).
    """

    names: tuple[str, ...]
    by_path_acceleration: Float64[np.ndarray, "n k blocks size"]
    by_squared_path_velocity: Float64[np.ndarray, "n k blocks size"]
    constant: Float64[np.ndarray, "n j blocks c"]
    by_path_velocity: Float64[np.ndarray, "n k blocks size"] | None
    path_acceleration_error: Float64[np.ndarray, "n blocks"]
    bounds: Float64[np.ndarray, "n blocks"]

    @property
    def without_overflow(self) -> "StopConstraint":
        """The same, with no admissible value where a coefficient has overflowed."""
        is_known = np.isfinite(self.path_acceleration_error) & np.isfinite(self.bounds)
        for part in (
            self.by_path_acceleration,
            self.by_squared_path_velocity,
            self.constant,
            self.by_path_velocity,
        ):
            if part is not None:
                is_known &= np.isfinite(part).all(axis=(1, 3))
        return StopConstraint(
            self.names,
            _finite_or_zero(self.by_path_acceleration),
            _finite_or_zero(self.by_squared_path_velocity),
            _finite_or_zero(self.constant),
            None if self.by_path_velocity is None else _finite_or_zero(self.by_path_velocity),
            np.where(is_known, self.path_acceleration_error, 0.0),
            np.where(is_known, self.bounds, -1.0),
        )

    @cached_property
    def is_satisfied_at_rest(self) -> Any:
        """Whether the bound is kept at rest, and at every constant s' <= 1; shape (n, blocks).

        At constant s': if a + b + c is within the bound, as it is for the motion itself, then
        a y + b r + c is y (a + b + c) + (1 - y) (c + b r / (1 + r)), and r / (1 + r) is 1/2 at
        most.
        """
        return self.static_utilization <= 1.0

    @cached_property
    def static_utilization(self) -> Float64[np.ndarray, "n blocks"]:
        """Utilization of the bound at rest and at constant s'; infinite where unknown."""
        constants = (
            [self.constant]
            if self.by_path_velocity is None
            else [self.constant, self.constant + self.by_path_velocity / 2]
        )
        sizes = [np.linalg.norm(constant, axis=3).max(axis=1) for constant in constants]
        utilization = np.maximum(sizes[0], sizes[-1]) / np.where(self.bounds > 0, self.bounds, 1.0)
        return np.where(self.bounds > 0, utilization, np.inf)

    def cell_conditions(
        self, cells: Indices, y: Array, widths: Array
    ) -> Iterator[tuple[int, Array, Array]]:
        """Yield the conditions in some cells: the norm of u - w x is at most `bounds`.

        In a cell of width h entered with y, y falls to y - 2 h x, and the quantity is affine in y
        except for r. That is between y / r0 and (y / r0 + r0) / 2, with r0 at the cell's entry: if
        both are within a convex bound, so is the value at r.

        Yields:
            0 on entering, 1 on leaving, 2 at rest; u (the quantity without braking) and w, each
            of shape (m, k, blocks, size).
        """
        by_acceleration, by_squared_velocity, constant = (
            self.by_path_acceleration[cells],
            self.by_squared_path_velocity[cells],
            self.constant[cells],
        )
        by_velocity = None if self.by_path_velocity is None else self.by_path_velocity[cells]
        y, double_widths, r0 = (x[:, None, None, None] for x in (y, 2 * widths, np.sqrt(y)))
        without_braking = (
            by_squared_velocity * y + constant + (0.0 if by_velocity is None else by_velocity * r0)
        )
        yield 0, without_braking, by_acceleration
        for weight in (1.0,) if by_velocity is None else (1.0, 0.5):
            gradient = (
                by_squared_velocity
                if by_velocity is None
                else by_squared_velocity + weight * by_velocity / r0
            )
            yield 1, without_braking, by_acceleration + double_widths * gradient
            at_rest = (
                constant if by_velocity is None else constant + (1 - weight) * by_velocity * r0
            )
            yield 2, np.broadcast_to(at_rest, without_braking.shape), by_acceleration

    def is_satisfied(self, cells: Indices, path_velocity: Array, path_acceleration: Array) -> Any:
        """Return in which cells the bound is kept for s' and s'' in intervals.

        Args:
            cells: Indices of the cells, shape (m,).
            path_velocity: Least and largest s', shape (2, m).
            path_acceleration: Least and largest s'', shape (2, m).
        """
        by_acceleration, by_squared_velocity, constant, by_velocity = self._hulls
        total = interval_product(by_squared_velocity[:, cells], np.maximum(path_velocity, 0.0) ** 2)
        total += interval_product(by_acceleration[:, cells], path_acceleration) + constant[:, cells]
        if by_velocity is not None:
            total += interval_product(by_velocity[:, cells], np.maximum(path_velocity, 0.0))
        sizes = np.linalg.norm(np.abs(total).max(axis=0), axis=2)
        sizes += (
            self.path_acceleration_error[cells] * np.abs(path_acceleration).max(axis=0)[:, None]
        )
        return (sizes <= self.bounds[cells]).all(axis=1)

    @cached_property
    def _hulls(self) -> tuple[Array, Array, Array, Array | None]:
        """Hulls of the coefficients d, a, c and b in all cells, cached for repeated use."""
        by_velocity = None if self.by_path_velocity is None else hull(self.by_path_velocity)
        return (
            hull(self.by_path_acceleration),
            hull(self.by_squared_path_velocity),
            hull(self.constant),
            by_velocity,
        )


def _finite_or_zero(form: Array) -> Array:
    return np.where(np.isfinite(form), form, 0.0)


def hull(form: Array) -> Array:
    """Return the smallest and the largest coefficient, shape (2, m, blocks, size)."""
    return np.stack([form.min(axis=1), form.max(axis=1)])


def interval_product(hulls: Array, interval: Array) -> Array:
    """Return the products of intervals, shape (2, m, blocks, size)."""
    factors = interval[:, :, None, None]
    a, b, c, d = (hulls[i] * factors[j] for i in range(2) for j in range(2))
    lower = np.minimum(np.minimum(a, b), np.minimum(c, d))
    return np.stack([lower, np.maximum(np.maximum(a, b), np.maximum(c, d))])
