"""Limit checks: joint positions and rates on the whole interval, from Bernstein coefficients.

Rounding errors (`rounding`) are added to all values.
"""

from collections.abc import Iterator
from math import isfinite
from typing import Any

import numpy as np

from planning.certify.intervals import bernstein
from planning.certify.intervals.angular_rates import angular_peak
from planning.certify.intervals.axis_drift import axis_drift
from planning.certify.intervals.rounding import UNIT_ROUNDOFF
from planning.certify.joints.follower_limits import follower_excesses, follower_utilizations
from planning.certify.joints.joint_bounds import POSITION_GAP, RATE_GAP, JointPeak
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.report.certificate import Check
from planning.domain.robot.joints import JointType

# Largest utilization (peak over limit) that passes.
MAX_UTILIZATION = 1 + 1e-6
# Tolerance of position bounds [rad or m].
POSITION_TOLERANCE = 1e-6
_RELATIVE_GAP = RATE_GAP
# Largest difference of angular rates and tangent derivatives that is neglected, relative to the
# limit.
_NEGLIGIBLE_DRIFT = 1e-7
# Attributes of `JointLimits`, by order of derivative from 1.
RATE_NAMES = ("velocity", "acceleration", "jerk")


def position_check(request: CertifyRequest) -> Check:
    """Return the check of the largest excess over position limits; negative means a reserve.

    Quaternions are exempt: they have no limits. Followers are checked against their own limits. The
    value is a guaranteed bound.
    """
    worst = Check("position", -np.inf, POSITION_TOLERANCE, "rad or m", 0.0, passed=True)
    if request.joint_bounds is not None:
        return _kernel_position_check(request, request.joint_bounds.position) or worst
    for names, excesses in (_group_excesses(request), follower_excesses(request)):
        if names:
            peak, row, fraction = bernstein.peak(_rows(excesses), POSITION_GAP)
            index, piece = divmod(row, request.trajectory.num_pieces)
            if not peak <= worst.value:
                time, passed = _time(request, piece, fraction), peak <= POSITION_TOLERANCE
                worst = Check(
                    "position",
                    peak,
                    POSITION_TOLERANCE,
                    "rad or m",
                    0.0,
                    passed,
                    names[index],
                    time,
                )
    return worst


def _kernel_position_check(request: CertifyRequest, peak: JointPeak) -> Check | None:
    """Return the check with the kernel's peak; None if no position is limited."""
    if peak.row < 0:
        return None
    names, limits = request.group.position_names, request.limits
    rows = [*np.flatnonzero(np.isfinite(limits.upper)), *np.flatnonzero(np.isfinite(limits.lower))]
    return Check(
        "position",
        peak.value,
        POSITION_TOLERANCE,
        "rad or m",
        0.0,
        peak.value <= POSITION_TOLERANCE,
        names[rows[peak.row]],
        _time(request, peak.piece, peak.fraction),
    )


def _group_excesses(request: CertifyRequest) -> tuple[list[str], Array]:
    """Return coordinate names, and excesses of the group over its bounds as coefficients."""
    limits, names = request.limits, request.group.position_names
    iq, iv = request.group.additive_indices
    bases = request.trajectory.bases.T[iq]
    values = request.bernstein_forms[0][iv] + bases[:, :, None]
    rounding_errors = request.rounding_errors[0][iv] + 2 * UNIT_ROUNDOFF * np.abs(bases).max(axis=1)
    upper, lower = limits.upper[iq], limits.lower[iq]
    above, below = np.flatnonzero(np.isfinite(upper)), np.flatnonzero(np.isfinite(lower))
    excesses = np.empty((len(above) + len(below), *values.shape[1:]))
    max_values, min_values = (upper - rounding_errors)[above], (lower + rounding_errors)[below]
    np.subtract(values[above], max_values[:, None, None], out=excesses[: len(above)])
    np.subtract(min_values[:, None, None], values[below], out=excesses[len(above) :])
    return [names[i] for i in (*iq[above].tolist(), *iq[below].tolist())], excesses


def rate_check(request: CertifyRequest, name: str, order: int) -> Check:
    """Return the check of peak over limit of velocity (1), acceleration (2) or jerk (3).

    The peak is that of each block's norm, and for accelerations with bounds by sign also the lowest
    and highest value. The value is a guaranteed bound, for floating joints on the true angular
    velocity and its derivatives, not on the tangent's.
    """
    worst = Check(name, 0.0, MAX_UTILIZATION, "1", 0.0, passed=True)
    utilizations = [
        *_utilizations(request, name, order),
        *follower_utilizations(request, name, order),
    ]
    if order == 2:
        utilizations += _signed_utilizations(request)
    for utilization, block, piece, fraction in utilizations:
        if not utilization <= worst.value:
            time, passed = _time(request, piece, fraction), utilization <= MAX_UTILIZATION
            worst = Check(name, utilization, MAX_UTILIZATION, "1", 0.0, passed, block, time)
    return worst


def _utilizations(
    request: CertifyRequest, name: str, order: int
) -> Iterator[tuple[float, str, int, float]]:
    """Yield peak over limit, block, piece and fraction: scalar blocks together, others each."""
    if request.joint_bounds is not None:
        peak = request.joint_bounds.rates[order - 1]
        if peak.row >= 0:
            errors = request.rounding_errors[order] / getattr(request.limits, name)
            block = request.group.blocks[peak.row][0]
            yield max(peak.value, 0.0) + float(errors.max()), block, peak.piece, peak.fraction
        return
    limits: list[float] = getattr(request.limits, name).tolist()
    limited = [
        (block, list(indices), limit)
        for (block, indices), limit in zip(request.group.blocks, limits, strict=True)
        if isfinite(limit)
    ]
    scalar = [entry for entry in limited if len(entry[1]) == 1]
    if scalar:
        columns = [indices[0] for _, indices, _ in scalar]
        bounds = np.array([limit for _, _, limit in scalar])
        utilizations = request.bernstein_forms[order][columns] / bounds[:, None, None]
        rows = _rows(np.concatenate([utilizations, -utilizations]))
        upper_bound, row, fraction = bernstein.peak(rows, _RELATIVE_GAP)
        index, piece = divmod(row % (len(rows) // 2), request.trajectory.num_pieces)
        rounding_error = float((request.rounding_errors[order][columns] / bounds).max())
        yield max(upper_bound, 0.0) + rounding_error, scalar[index][0], piece, fraction
    if len(scalar) == len(limited):
        return
    angular = angular_blocks(request)
    for block, indices, limit in limited:
        if len(indices) > 1:
            bound_of = _angular_bound if block in angular else _norm_bound
            upper_bound, piece, fraction = bound_of(request, indices, order, limit)
            rounding_error = float(np.linalg.norm(request.rounding_errors[order][indices]))
            yield (upper_bound + rounding_error) / limit, block, piece, fraction


def _signed_utilizations(request: CertifyRequest) -> Iterator[tuple[float, str, int, float]]:
    """Yield the same for accelerations with bounds that differ by sign, for each bounded block."""
    if not request.acceleration_bounds:
        return
    columns = {name: indices[0] for name, indices in request.group.blocks if len(indices) == 1}
    for name, (lowest, highest) in request.acceleration_bounds.items():
        column = columns[name]
        rows, rounding_error = (
            request.bernstein_forms[2][column],
            request.rounding_errors[2][column],
        )
        upper_bound, row, fraction = bernstein.peak(
            np.concatenate([rows / highest, rows / lowest]), _RELATIVE_GAP
        )
        upper_bound = max(upper_bound, 0.0) + float(rounding_error) / min(highest, -lowest)
        yield float(upper_bound), name, row % len(rows), fraction


def _norm_bound(
    request: CertifyRequest, indices: list[int], order: int, limit: float, rows: Any = slice(None)
) -> tuple[float, int, float]:
    """Bound the norm of a block's derivative on pieces; return bound, piece and fraction."""
    forms = request.bernstein_forms[order][indices][:, rows]
    squares = bernstein.square_norm(np.moveaxis(forms, 0, -1))
    upper_bound, row, fraction = bernstein.peak(squares, _RELATIVE_GAP * limit**2)
    return float(np.sqrt(max(upper_bound, 0.0))), row, fraction


def _rows(forms: Array) -> Array:
    return forms.reshape(-1, forms.shape[-1])


def _time(request: CertifyRequest, piece: int, fraction: float) -> float:
    begin, end = request.trajectory.breaks[piece : piece + 2]
    return float(begin + fraction * (end - begin))


def _angular_bound(
    request: CertifyRequest, indices: list[int], order: int, limit: float
) -> tuple[float, int, float]:
    """Bound the norm of a floating joint's angular rate; return bound, piece and fraction.

    On pieces with a fixed rotation axis, the tangent's own derivatives are the rates.
    """
    drift = _axis_drift(request, indices, order)
    is_fixed = drift <= _NEGLIGIBLE_DRIFT * limit
    bounds: list[tuple[float, int, float]] = []
    if is_fixed.any():
        rows = np.flatnonzero(is_fixed)
        upper_bound, row, fraction = _norm_bound(request, indices, order, limit, rows)
        bounds.append((upper_bound + float(drift[rows].max()), int(rows[row]), fraction))
    if not is_fixed.all():
        rows = np.flatnonzero(~is_fixed)
        coefficients = request.trajectory.coefficients[rows][:, :, indices]
        widths = np.diff(request.trajectory.breaks)[rows]
        upper_bound, row, fraction = angular_peak(
            coefficients, widths, order, 10 * _RELATIVE_GAP * limit
        )
        bounds.append((upper_bound, int(rows[row]), fraction))
    return max(bounds, key=lambda entry: entry[0])


def has_fixed_axes(request: CertifyRequest, indices: list[int], limits: list[float]) -> bool:
    """Return whether every piece rotates a floating joint about a fixed axis.

    Args:
        request: The request with the trajectory.
        indices: The joint's angular coordinates in v.
        limits: Limits by order of derivative, from 1: differences below `_NEGLIGIBLE_DRIFT` of them
            are neglected.
    """
    return all(
        bool((_axis_drift(request, indices, order) <= _NEGLIGIBLE_DRIFT * limit).all())
        for order, limit in enumerate(limits, start=1)
    )


def _axis_drift(request: CertifyRequest, indices: list[int], order: int) -> Array:
    curve = request.trajectory
    return axis_drift(curve.coefficients[:, :, indices], np.diff(curve.breaks), order)


def angular_blocks(request: CertifyRequest) -> set[str]:
    """Return the names of the blocks that are angular velocities in space."""
    floating = [joint for joint in request.group.joints if joint.type is JointType.FLOATING]
    return {name for joint in floating for name, indices in joint.blocks if indices[0] == 0}
