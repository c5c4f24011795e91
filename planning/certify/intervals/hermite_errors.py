"""Hermite interpolation errors: bounds on the sample spacing from the derivatives of a motion.

Let a polynomial of degree 2 k - 1 agree with a function and its first k - 1 derivatives at both
ends of an interval of length h, and let M bound the function's derivative of order 2 k there. Then
the r-th derivatives differ by at most c_r h^(2 k - r) M (Birkhoff and Priver, "Hermite
interpolation errors for derivatives", J. Math. and Physics 46, 1967, for k = 2 and 3; for k = 1 it
is h^2 M / 8).

With samples at all breaks of a motion every interval lies in one piece, except for ramps between
accelerations, which are linear, so that no rate is larger than at one of their ends. Linear
interpolation is nowhere faster than the motion, whose mean speed it has, and exceeds no position
limit.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planning.certify.intervals import bernstein
from planning.certify.joints.limit_checks import (
    MAX_UTILIZATION,
    POSITION_TOLERANCE,
    RATE_NAMES,
    rate_check,
)
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.curves.interpolation_proof import Interpolation

# c_r for r = 0, 1, ...
_ERROR_CONSTANTS: dict[Interpolation, tuple[float, ...]] = {
    "linear": (1 / 8,),
    "cubic": (1 / 384, 3**0.5 / 216, 1 / 12, 1 / 2),
    "quintic": (1 / 46_080, 5**0.5 / 30_000, 1 / 1_920, 1 / 120),
}
_ORDERS: dict[Interpolation, int] = {"linear": 2, "cubic": 4, "quintic": 6}
# Largest jump of acceleration under jerk limits, relative to its limit, on both sides together.
_MAX_ACCELERATION_JUMP = 4e-4
# Share of the reserve for interpolation errors; the rest is for errors of the samples.
_INTERPOLATION_FRACTION = 0.9


@dataclass(frozen=True)
class HermiteErrors:
    """Interpolation errors of one motion, compared with the reserve to its limits.

    Attributes:
        request: The motion, proven, and its limits; every coordinate has limits of its own, the
            same in both directions.
    """

    request: CertifyRequest

    @classmethod
    def of(cls, request: CertifyRequest) -> "HermiteErrors | None":
        """Build from a request; None if its limits are not of that kind."""
        is_scalar = all(len(indices) == 1 for _, indices in request.group.blocks)
        return cls(request) if is_scalar and not request.acceleration_bounds else None

    @cached_property
    def _widths(self) -> Array:
        return self.request.trajectory.widths

    @cached_property
    def _limit_margins(self) -> list[Array]:
        """The reserve to limits on positions and rates, by order, each shape (nv, n)."""
        request = self.request
        limits, columns = request.limits, [indices[0] for _, indices in request.group.blocks]
        positions = request.bernstein_forms[0] + request.trajectory.bases.T[:, :, None]
        position_margins = np.minimum(
            limits.upper[:, None] - positions.max(axis=2),
            positions.min(axis=2) - limits.lower[:, None],
        )
        margins = [np.maximum(position_margins, 0.0) + POSITION_TOLERANCE]
        for order, form in enumerate(request.bernstein_forms[1:], start=1):
            name = RATE_NAMES[order - 1]
            limit = np.empty(len(columns))
            limit[columns] = getattr(limits, name)
            peaks = np.abs(form).max(axis=2) / limit[:, None]
            max_utilization = rate_check(request, name, order).value
            utilizations = np.where(
                np.isfinite(limit)[:, None], np.minimum(peaks, max_utilization), 0.0
            )
            margins.append((MAX_UTILIZATION - utilizations) * limit[:, None])
        return margins

    def sample_spacing(self, kind: Interpolation) -> Array:
        """Return the sample spacing on each piece that keeps the limits [s], shape (n,).

        The condition is sufficient, not necessary: near a limit there is almost no reserve.
        """
        spacings = [np.full(len(self._widths), np.inf)]
        derivative_bounds = self._derivative_bounds(kind)
        order, errors = _ORDERS[kind], _ERROR_CONSTANTS[kind]
        if kind != "linear" and derivative_bounds.any():
            for r, margins in enumerate(self._limit_margins):
                spacings.append(
                    _max_spacing(margins, errors[r] * derivative_bounds, order - r).min(axis=0)
                )
            if self.request.jerk:
                step = (
                    np.full_like(derivative_bounds, _MAX_ACCELERATION_JUMP)
                    * self._limit(2)[:, None]
                )
                spacings.append(
                    _max_spacing(step, errors[2] * derivative_bounds, order - 2).min(axis=0)
                )
        return np.min(spacings, axis=0)

    def max_sample_period(
        self, kind: Interpolation, lever_arms: Array, allowed_approach: float
    ) -> float:
        """Return the longest sample period that is proven to keep limits and clearance [s].

        It is the duration if every period is proven to, and 0 if none is.

        Args:
            kind: Interpolation used by the receiver of the samples.
            lever_arms: Largest approach of two shapes per change of each coordinate, shape (nv,).
            allowed_approach: Allowed approach of any two shapes [m].
        """
        derivative_bounds = self._derivative_bounds(kind)
        if not derivative_bounds.any():
            return self.request.trajectory.duration
        approach_bounds = (derivative_bounds * lever_arms[:, None]).sum(axis=0)
        clearance_period = _max_spacing(
            np.full_like(approach_bounds, allowed_approach),
            _ERROR_CONSTANTS[kind][0] * approach_bounds,
            _ORDERS[kind],
        )
        period = np.minimum(self.sample_spacing(kind), clearance_period)
        is_shorter = period < self._widths
        return (
            float(period[is_shorter].min())
            if is_shorter.any()
            else self.request.trajectory.duration
        )

    def _limit(self, order: int) -> Array:
        limits = self.request.limits
        return limits.per_coordinate(getattr(limits, RATE_NAMES[order - 1]))

    @cached_property
    def _derivative_cache(self) -> dict[Interpolation, Array]:
        return {}

    def _derivative_bounds(self, kind: Interpolation) -> Array:
        """Return a bound on the derivative in the error term, shape (nv, n)."""
        bounds = self._derivative_cache.get(kind)
        if bounds is None:
            power = bernstein.derivative(self.request.trajectory.coefficients, _ORDERS[kind])
            rows = bernstein.rows_from_power(power, self._widths)
            bounds = self._derivative_cache[kind] = np.abs(rows).max(axis=2)
        return bounds


def _max_spacing(margins: Array, errors: Array, power: int) -> Array:
    """Return the largest h with errors h^power within a share of the reserve."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        spacing = (_INTERPOLATION_FRACTION * np.maximum(margins, 0.0) / errors) ** (1 / power)
    return np.where(errors > 0, spacing, np.inf)
