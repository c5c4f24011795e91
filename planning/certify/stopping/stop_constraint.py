"""StopConstraint: something that is limited and changes with how a motion is slowed down.

Where a motion is followed with s' and s'', let y = s'^2, r = s' and x = -s''. What is limited is

    |bend y + drag r + rest - slope x| <= bound,

whose four coefficients are polynomials on every cell. Of accelerations `bend` and `slope` are the
second derivative and the first, and `rest` is what bounds by sign are counted from; of torques
`rest` is gravity, and `drag` is what damping takes.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float64

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]


@dataclass(frozen=True)
class StopConstraint:
    """Some blocks of as many coordinates each, in n cells.

    Coefficients are in Bernstein form, or values at so many places between which they are straight:
    what a convex bound says of all of them, it says of the whole cell.

    Attributes:
        names: Of the blocks.
        slope: Shape (n, k, blocks, size).
        bend: The same.
        rest: The same, or of shapes that broadcast to it.
        drag: The same; None for nothing.
        off_slope: By how much slope may be off, shape (n, blocks).
        bounds: What the norm is bounded by, less what all else may be off for y and r up to 1;
            negative where nothing is known. Shape (n, blocks).
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
        """The same, with no bound where something has overflowed: nothing is known there."""
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
        """Where it is within its bound at a stand, and at every s' with s'' = 0; (n, blocks).

        Of the latter: if `bend + drag + rest` is, as it is of the motion itself, then with y the
        whole is y (bend + drag + rest) + (1 - y) (rest + drag r / (1 + r)), and r / (1 + r) is 1/2
        at most.
        """
        return self.held_use <= 1.0

    @cached_property
    def held_use(self) -> Float64[np.ndarray, "n blocks"]:
        """The same as a share of the bound; infinite where nothing is known."""
        rests = [self.rest] if self.drag is None else [self.rest, self.rest + self.drag / 2]
        sizes = [np.linalg.norm(rest, axis=3).max(axis=1) for rest in rests]
        used = np.maximum(sizes[0], sizes[-1]) / np.where(self.bounds > 0, self.bounds, 1.0)
        return np.where(self.bounds > 0, used, np.inf)

    def sides(self, at: Indices, y: Array, widths: Array) -> Iterator[tuple[int, Array, Array]]:
        """Yield what must hold in some cells, as `begun - part x` of norm `bounds` at most.

        In a cell that is entered with y and has the width h, y falls to y - 2 h x, and all of it is
        affine in y but for r. That lies between y / r0 and (y / r0 + r0) / 2, with r0 where the
        cell is entered: where both of them are within a convex bound, so is r.

        Yields:
            0 on entering, 1 on leaving, 2 at a stand; begun and part, shape (m, k, blocks, size).
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
        """Return in which cells the bound is kept while s' and s'' are in intervals.

        Args:
            at: Which cells, shape (m,).
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
        """Those of slope, bend, rest and drag in all cells: they are asked for again and again."""
        drag = None if self.drag is None else hull(self.drag)
        return hull(self.slope), hull(self.bend), hull(self.rest), drag


def _finite(form: Array) -> Array:
    return np.where(np.isfinite(form), form, 0.0)


def hull(form: Array) -> Array:
    """Return the least and the largest coefficient, shape (2, m, blocks, size)."""
    return np.stack([form.min(axis=1), form.max(axis=1)])


def spread(hulls: Array, interval: Array) -> Array:
    """Return the products of intervals, shape (2, m, blocks, size)."""
    factors = interval[:, :, None, None]
    a, b, c, d = (hulls[i] * factors[j] for i in range(2) for j in range(2))
    least = np.minimum(np.minimum(a, b), np.minimum(c, d))
    return np.stack([least, np.maximum(np.maximum(a, b), np.maximum(c, d))])
