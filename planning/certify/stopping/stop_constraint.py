"""StopConstraint: a limit on a quantity that depends on how a motion is slowed down.

For a motion followed with s' and s'', let y = s'^2, r = s' and x = -s''. The constraint is

    |bend y + drag r + rest - slope x| <= bound,

whose four coefficients are polynomials on every cell. For accelerations `bend` and `slope` are the
second derivative and the first, and `rest` is the middle of bounds that differ by sign; for torques
`rest` is gravity, and `drag` is damping.
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

    Coefficients are in Bernstein form, or values at places between which the quantity is linear:
    a convex bound that holds for all of them holds on the whole cell.

    Attributes:
        names: Names of the blocks.
        slope: Coefficients of -x, shape (n, k, blocks, size).
        bend: Coefficients of y, same shape.
        rest: Constant term, same shape or one that broadcasts to it.
        drag: Coefficients of r, same shape; None for zero.
        off_slope: Bound on the error of `slope`, shape (n, blocks).
        bounds: Bound on the norm, minus the errors of all other coefficients for y and r up to 1;
            negative where the coefficients are unknown. Shape (n, blocks).
    """

    names: tuple[str, ...]
    slope: Float64[np.ndarray, "n k blocks size"]
    bend: Float64[np.ndarray, "n k blocks size"]
    rest: Float64[np.ndarray, "n j blocks c"]
    drag: Float64[np.ndarray, "n k blocks size"] | None
    off_slope: Float64[np.ndarray, "n blocks"]
    bounds: Float64[np.ndarray, "n blocks"]

    @property
    def where_known(self) -> "StopConstraint":
        """The same, with no admissible value where a coefficient has overflowed."""
        is_known = np.isfinite(self.off_slope) & np.isfinite(self.bounds)
        for part in (self.slope, self.bend, self.rest, self.drag):
            if part is not None:
                is_known &= np.isfinite(part).all(axis=(1, 3))
        return StopConstraint(
            self.names,
            _finite(self.slope),
            _finite(self.bend),
            _finite(self.rest),
            None if self.drag is None else _finite(self.drag),
            np.where(is_known, self.off_slope, 0.0),
            np.where(is_known, self.bounds, -1.0),
        )

    @cached_property
    def holds(self) -> Any:
        """Whether the bound is kept at rest, and at every constant s' <= 1; shape (n, blocks).

        At constant s': if `bend + drag + rest` is within the bound, as it is for the motion itself,
        then with y the whole is y (bend + drag + rest) + (1 - y) (rest + drag r / (1 + r)), and
        r / (1 + r) is 1/2 at most.
        """
        return self.held_use <= 1.0

    @cached_property
    def held_use(self) -> Float64[np.ndarray, "n blocks"]:
        """Utilization of the bound at rest and at constant s'; infinite where unknown."""
        rests = [self.rest] if self.drag is None else [self.rest, self.rest + self.drag / 2]
        sizes = [np.linalg.norm(rest, axis=3).max(axis=1) for rest in rests]
        used = np.maximum(sizes[0], sizes[-1]) / np.where(self.bounds > 0, self.bounds, 1.0)
        return np.where(self.bounds > 0, used, np.inf)

    def sides(self, at: Indices, y: Array, widths: Array) -> Iterator[tuple[int, Array, Array]]:
        """Yield the conditions in some cells, as `begun - part x` of norm `bounds` at most.

        In a cell of width h entered with y, y falls to y - 2 h x, and the quantity is affine in y
        but for r. That lies between y / r0 and (y / r0 + r0) / 2, with r0 at the cell's entry: if
        both are within a convex bound, so is the value at r.

        Yields:
            0 on entering, 1 on leaving, 2 at rest; begun and part, shape (m, k, blocks, size).
        """
        slope, bend, rest = self.slope[at], self.bend[at], self.rest[at]
        drag = None if self.drag is None else self.drag[at]
        y, twice, r0 = (x[:, None, None, None] for x in (y, 2 * widths, np.sqrt(y)))
        begun = bend * y + rest + (0.0 if drag is None else drag * r0)
        yield 0, begun, slope
        for share in (1.0,) if drag is None else (1.0, 0.5):
            steep = bend if drag is None else bend + share * drag / r0
            yield 1, begun, slope + twice * steep
            stood = rest if drag is None else rest + (1 - share) * drag * r0
            yield 2, np.broadcast_to(stood, begun.shape), slope

    def used(self, at: Indices, rate: Array, ramp: Array) -> Any:
        """Return in which cells the bound is kept for s' and s'' in intervals.

        Args:
            at: Indices of the cells, shape (m,).
            rate: Least and largest s', shape (2, m).
            ramp: Least and largest s'', shape (2, m).
        """
        slope, bend, rest, drag = self._hulls
        total = spread(bend[:, at], np.maximum(rate, 0.0) ** 2)
        total += spread(slope[:, at], ramp) + rest[:, at]
        if drag is not None:
            total += spread(drag[:, at], np.maximum(rate, 0.0))
        sizes = np.linalg.norm(np.abs(total).max(axis=0), axis=2)
        sizes += self.off_slope[at] * np.abs(ramp).max(axis=0)[:, None]
        return (sizes <= self.bounds[at]).all(axis=1)

    @cached_property
    def _hulls(self) -> tuple[Array, Array, Array, Array | None]:
        """Hulls of slope, bend, rest and drag in all cells, cached for repeated use."""
        drag = None if self.drag is None else hull(self.drag)
        return hull(self.slope), hull(self.bend), hull(self.rest), drag


def _finite(form: Array) -> Array:
    return np.where(np.isfinite(form), form, 0.0)


def hull(form: Array) -> Array:
    """Return the smallest and the largest coefficient, shape (2, m, blocks, size)."""
    return np.stack([form.min(axis=1), form.max(axis=1)])


def spread(hulls: Array, interval: Array) -> Array:
    """Return the products of intervals, shape (2, m, blocks, size)."""
    factors = interval[:, :, None, None]
    a, b, c, d = (hulls[i] * factors[j] for i in range(2) for j in range(2))
    least = np.minimum(np.minimum(a, b), np.minimum(c, d))
    return np.stack([least, np.maximum(np.maximum(a, b), np.maximum(c, d))])
