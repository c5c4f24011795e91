"""MotionCells: a trajectory in short cells, with rate bounds that hold on all of each.

Rates are Bernstein coefficients of a common degree: a convex bound that holds for all coefficients
of a sum holds for the sum itself at every instant of the cell. They come from the trajectory's
powers in two steps, each with a rounding error of at most `rounding_bounds`: twice that is
subtracted from limits, and added to sizes.
"""

from dataclasses import dataclass
from functools import cached_property
from math import factorial
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals import bernstein
from planning.certify.intervals.angular_velocity_bounds import angular_velocity_bounds
from planning.certify.intervals.equal_split import split_equally
from planning.certify.joints.limit_checks import (
    MAX_UTILIZATION,
    RATE_NAMES,
    angular_blocks,
    has_fixed_axes,
)
from planning.certify.request import CertifyRequest
from planning.certify.stopping.stop_constraint import StopConstraint, hull
from planning.domain.arrays import Array


@dataclass(frozen=True)
class BlockRates:
    """Rates of blocks with the same number of coordinates.

    Attributes:
        names: Names of the blocks.
        bernstein_forms: Bernstein coefficients by order of derivative, from the first, shape
            (n, k, blocks, size).
        limits: By order: limit of the norm of each block, shape (blocks,).
        acceleration_offsets: Offset to subtract from accelerations before the limit, where bounds
            differ by sign, shape (blocks,).
        is_angular: Whether these are bounds on the norm of an angular rate and its derivatives,
            without direction and with one coordinate each.
    """

    names: tuple[str, ...]
    bernstein_forms: tuple[Float64[np.ndarray, "n k blocks size"], ...]
    limits: tuple[Float64[np.ndarray, " blocks"], ...]
    acceleration_offsets: Float64[np.ndarray, " blocks"]
    is_angular: bool = False

    @cached_property
    def hulls(self) -> tuple[Array, ...]:
        """Smallest and largest coefficients by order, shape (2, n, blocks, size)."""
        return tuple(hull(form) for form in self.bernstein_forms)

    @cached_property
    def acceleration_constraint(self) -> StopConstraint:
        """The acceleration limits as a constraint on stops."""
        first, second = self.bernstein_forms[:2]
        cells, _, blocks, _ = first.shape
        return StopConstraint(
            self.names,
            -first if self.is_angular else first,
            second,
            np.broadcast_to(
                -self.acceleration_offsets[:, None] * MAX_UTILIZATION, (cells, 1, blocks, 1)
            ),
            None,
            np.zeros((cells, blocks)),
            np.broadcast_to(self.limits[1] * MAX_UTILIZATION, (cells, blocks)),
        )


@dataclass(frozen=True)
class MotionCells:
    """Cells of a trajectory, with rates and constraints on stops.

    Attributes:
        begins: First instants [s], shape (n,).
        widths: Durations [s], shape (n,).
        rates: Rates of all blocks; blocks of one coordinate are together.
        stop_constraints: Other constraints on stops (frame accelerations, torques).
    """

    begins: Float64[np.ndarray, " n"]
    widths: Float64[np.ndarray, " n"]
    rates: tuple[BlockRates, ...]
    stop_constraints: tuple[StopConstraint, ...] = ()

    @property
    def all_constraints(self) -> tuple[StopConstraint, ...]:
        """All constraints on stops under acceleration limits."""
        return (
            *(block_rates.acceleration_constraint for block_rates in self.rates),
            *self.stop_constraints,
        )

    @cached_property
    def can_rest(self) -> Any:
        """Whether the motion can rest in each cell, and continue at any s' up to 1, shape (n,)."""
        can_rest = np.ones(len(self.begins), dtype=bool)
        for constraint in self.stop_constraints:
            can_rest &= constraint.is_satisfied_at_rest.all(axis=1)
        return can_rest

    @property
    def end(self) -> float:
        """Last instant of the motion [s]."""
        return float(self.begins[-1] + self.widths[-1])

    def path_length_bounds(self) -> tuple[tuple[str, ...], Float64[np.ndarray, "n blocks"]]:
        """Return block names, and bounds on the path length of each in each cell [rad or m].

        A norm is convex, and each polynomial of the basis covers the same share of a cell.
        """
        names = tuple(name for rates in self.rates for name in rates.names)
        sizes = [
            np.linalg.norm(rates.bernstein_forms[0], axis=3).mean(axis=1) for rates in self.rates
        ]
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
    return MotionCells(begins, widths, tuple(_block_rates(request, forms)))


def _form(taylor: Array, order: int, widths: Array) -> Array:
    """Return Bernstein coefficients of a derivative, in the degree of the tangent."""
    power = bernstein.derivative(taylor, order)
    padding = ((0, 0), (0, taylor.shape[1] - power.shape[1]), (0, 0))
    return bernstein.from_power(np.pad(power, padding), widths)


def _block_rates(request: CertifyRequest, forms: list[Array]) -> list[BlockRates]:
    """Return the rates of all scalar blocks together, and of each other block."""
    blocks = [(name, list(indices)) for name, indices in request.group.blocks]
    rounding_errors = [
        np.array([2 * np.linalg.norm(error[indices]) for _, indices in blocks])
        for error in request.rounding_errors[1 : len(forms)]
    ]
    shared = request.limits_with_followers
    limits = [
        getattr(shared, name) - error
        for name, error in zip(RATE_NAMES, rounding_errors, strict=False)
    ]
    scalar = [i for i, (_, indices) in enumerate(blocks) if len(indices) == 1]
    block_rates: list[BlockRates] = []
    if scalar:
        columns = [blocks[i][1][0] for i in scalar]
        names = tuple(blocks[i][0] for i in scalar)
        velocity, acceleration, *jerk = (limit[scalar] for limit in limits)
        acceleration_offsets, acceleration = _acceleration_ranges(request, names, acceleration)
        block_rates.append(
            BlockRates(
                names,
                tuple(form[:, :, columns, None] for form in forms[1:]),
                (velocity, acceleration, *jerk),
                acceleration_offsets,
            )
        )
    angular = angular_blocks(request)
    for i, (name, indices) in enumerate(blocks):
        if len(indices) > 1:
            block_forms = [form[:, :, None, indices] for form in forms]
            bounds = tuple(limit[i : i + 1] for limit in limits)
            largest = [float(bound[0]) for bound in bounds]
            is_angular = name in angular and not has_fixed_axes(request, indices, largest)
            rates = (
                _angular_rate_bounds(block_forms, [error[i] for error in rounding_errors])
                if is_angular
                else block_forms[1:]
            )
            block_rates.append(BlockRates((name,), tuple(rates), bounds, np.zeros(1), is_angular))
    return block_rates


def _acceleration_ranges(
    request: CertifyRequest, names: tuple[str, ...], limits: Array
) -> tuple[Array, Array]:
    """Return middle and half width of the acceleration range of scalar blocks.

    A block without bounds by sign has its limit in both directions.
    """
    bounds = request.acceleration_bounds
    allowed = [bounds.get(name, (-np.inf, np.inf)) for name in names]
    lowest = np.maximum([low for low, _ in allowed], -limits)
    highest = np.minimum([high for _, high in allowed], limits)
    return (highest + lowest) / 2, (highest - lowest) / 2


def _angular_rate_bounds(forms: list[Array], rounding_errors: list[float]) -> list[Array]:
    """Return bounds on the norm of an angular velocity and its derivatives."""
    sizes = np.stack([
        np.linalg.norm(form, axis=3).max(axis=1) + error
        for form, error in zip(forms[1:], rounding_errors, strict=True)
    ])
    return [size[:, None, :, None] for size in angular_velocity_bounds(sizes)]
