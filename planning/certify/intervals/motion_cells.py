"""MotionCells: a trajectory in short cells, with rate bounds that hold on all of each.

Rates are Bernstein coefficients of a common degree: a convex bound that holds for all coefficients
of a sum holds for the sum itself at every instant of the cell. They come from the trajectory's
powers in two steps, each with a rounding error of at most `rounding`: twice that is subtracted from
limits, and added to sizes.
"""

from dataclasses import dataclass
from functools import cached_property
from math import factorial
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals import bernstein
from planning.certify.intervals.equal_parts import split_equally
from planning.certify.intervals.turn_bounds import turn_bounds
from planning.certify.joints.limit_checks import (
    MAX_UTILISATION,
    RATES,
    has_fixed_axes,
    turning_blocks,
)
from planning.certify.request import CertifyRequest
from planning.certify.stopping.stop_constraint import StopConstraint, hull
from planning.domain.arrays import Array


@dataclass(frozen=True)
class BlockRates:
    """Rates of blocks with the same number of coordinates.

    Attributes:
        names: Names of the blocks.
        forms: Bernstein coefficients by order of derivative, from the first, shape
            (n, k, blocks, size).
        limits: By order: limit of the norm of each block, shape (blocks,).
        middles: Offset to subtract from accelerations before the limit, where bounds differ by
            sign, shape (blocks,).
        is_turning: Whether these are bounds on the norm of an angular rate and its derivatives,
            without direction and with one coordinate each.
    """

    names: tuple[str, ...]
    forms: tuple[Float64[np.ndarray, "n k blocks size"], ...]
    limits: tuple[Float64[np.ndarray, " blocks"], ...]
    middles: Float64[np.ndarray, " blocks"]
    is_turning: bool = False

    @cached_property
    def hulls(self) -> tuple[Array, ...]:
        """Smallest and largest coefficients by order, shape (2, n, blocks, size)."""
        return tuple(hull(form) for form in self.forms)

    @cached_property
    def load(self) -> StopConstraint:
        """The acceleration limits as a constraint on stops."""
        slope, bend = self.forms[:2]
        cells, _, blocks, _ = slope.shape
        return StopConstraint(
            self.names,
            -slope if self.is_turning else slope,
            bend,
            np.broadcast_to(-self.middles[:, None] * MAX_UTILISATION, (cells, 1, blocks, 1)),
            None,
            np.zeros((cells, blocks)),
            np.broadcast_to(self.limits[1] * MAX_UTILISATION, (cells, blocks)),
        )


@dataclass(frozen=True)
class MotionCells:
    """Cells of a trajectory, with rates and constraints on stops.

    Attributes:
        begins: First instants [s], shape (n,).
        widths: Durations [s], shape (n,).
        rates: Rates of all blocks; blocks of one coordinate are together.
        loads: Other constraints on stops (frame accelerations, torques).
    """

    begins: Float64[np.ndarray, " n"]
    widths: Float64[np.ndarray, " n"]
    rates: tuple[BlockRates, ...]
    loads: tuple[StopConstraint, ...] = ()

    @property
    def all_loads(self) -> tuple[StopConstraint, ...]:
        """All constraints on stops under acceleration limits."""
        return (*(rates.load for rates in self.rates), *self.loads)

    @cached_property
    def holds(self) -> Any:
        """Whether the motion can rest in each cell, and continue at any s' up to 1, shape (n,)."""
        holds = np.ones(len(self.begins), dtype=bool)
        for load in self.loads:
            holds &= load.holds.all(axis=1)
        return holds

    @property
    def end(self) -> float:
        """Last instant of the motion [s]."""
        return float(self.begins[-1] + self.widths[-1])

    def ways(self) -> tuple[tuple[str, ...], Float64[np.ndarray, "n blocks"]]:
        """Return block names, and bounds on the path length of each in each cell [rad or m].

        A norm is convex, and each polynomial of the basis covers the same share of a cell.
        """
        names = tuple(name for rates in self.rates for name in rates.names)
        sizes = [np.linalg.norm(rates.forms[0], axis=3).mean(axis=1) for rates in self.rates]
        return names, np.concatenate(sizes, axis=1) * self.widths[:, None]


def motion_cells(request: CertifyRequest, count: int) -> MotionCells:
    """Cut a trajectory into about `count` cells, at least one for each of its pieces."""
    curve = request.trajectory
    pieces = np.diff(curve.breaks)
    counts = np.maximum(1, np.ceil(pieces / (curve.duration / count))).astype(np.int64)
    owners, within = split_equally(counts)
    widths = (pieces / counts)[owners]
    begins = curve.breaks[owners] + within * widths
    terms = curve.coefficients.shape[1]
    powers = [curve.tangents(begins, k) / factorial(k) for k in range(terms)]
    taylor = np.stack(powers, axis=1)
    forms = [_form(taylor, order, widths) for order in range(4 if request.jerk else 3)]
    return MotionCells(begins, widths, tuple(_by_size(request, forms)))


def _form(taylor: Array, order: int, widths: Array) -> Array:
    """Return Bernstein coefficients of a derivative, in the degree of the tangent."""
    power = bernstein.derivative(taylor, order)
    padding = ((0, 0), (0, taylor.shape[1] - power.shape[1]), (0, 0))
    return bernstein.from_power(np.pad(power, padding), widths)


def _by_size(request: CertifyRequest, forms: list[Array]) -> list[BlockRates]:
    """Return the rates of all scalar blocks together, and of each other block."""
    blocks = [(name, list(indices)) for name, indices in request.group.blocks]
    hidden = [
        np.array([2 * np.linalg.norm(off[indices]) for _, indices in blocks])
        for off in request.rounding[1 : len(forms)]
    ]
    shared = request.shared_limits
    limits = [getattr(shared, name) - off for name, off in zip(RATES, hidden, strict=False)]
    scalar = [i for i, (_, indices) in enumerate(blocks) if len(indices) == 1]
    found: list[BlockRates] = []
    if scalar:
        columns = [blocks[i][1][0] for i in scalar]
        names = tuple(blocks[i][0] for i in scalar)
        velocity, acceleration, *jerk = (limit[scalar] for limit in limits)
        middles, acceleration = _by_sign(request, names, acceleration)
        found.append(
            BlockRates(
                names,
                tuple(form[:, :, columns, None] for form in forms[1:]),
                (velocity, acceleration, *jerk),
                middles,
            )
        )
    turning = turning_blocks(request)
    for i, (name, indices) in enumerate(blocks):
        if len(indices) > 1:
            own = [form[:, :, None, indices] for form in forms]
            bounds = tuple(limit[i : i + 1] for limit in limits)
            largest = [float(bound[0]) for bound in bounds]
            is_turning = name in turning and not has_fixed_axes(request, indices, largest)
            rates = _turning(own, [off[i] for off in hidden]) if is_turning else own[1:]
            found.append(BlockRates((name,), tuple(rates), bounds, np.zeros(1), is_turning))
    return found


def _by_sign(request: CertifyRequest, names: tuple[str, ...], limits: Array) -> tuple[Array, Array]:
    """Return middle and half width of the acceleration range of scalar blocks.

    A block without bounds by sign has its limit in both directions.
    """
    bounds = request.acceleration_bounds
    allowed = [bounds.get(name, (-np.inf, np.inf)) for name in names]
    lowest = np.maximum([low for low, _ in allowed], -limits)
    highest = np.minimum([high for _, high in allowed], limits)
    return (highest + lowest) / 2, (highest - lowest) / 2


def _turning(forms: list[Array], hidden: list[float]) -> list[Array]:
    """Return bounds on the norm of an angular velocity and its derivatives."""
    sizes = np.stack([
        np.linalg.norm(form, axis=3).max(axis=1) + off
        for form, off in zip(forms[1:], hidden, strict=True)
    ])
    return [size[:, None, :, None] for size in turn_bounds(sizes)]
