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
from planning.certify.intervals.rounding import UNIT
from planning.certify.joints.follower_limits import follower_excesses, follower_uses
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.report.certificate import Check
from planning.domain.robot.joints import JointType

# Largest utilization (peak over limit) that passes; the tolerance of position bounds is DUST.
MAX_UTILISATION = 1 + 1e-6
DUST = 1e-6
_RELATIVE_GAP = 1e-8
# Largest difference of angular rates and tangent derivatives that is neglected, relative to the
# limit.
_LEAST_DRIFT = 1e-7
# Attributes of `JointLimits`, by order of derivative from 1.
RATES = ("velocity", "acceleration", "jerk")


def position_check(request: CertifyRequest) -> Check:
    """Return the check of the largest excess over position limits; negative means a reserve.

    Quaternions are exempt: they have no limits. Followers are checked against their own limits. The
    value is a guaranteed bound.
    """
    worst = Check("position", -np.inf, DUST, "rad or m", 0.0, passed=True)
    for names, excesses in (_own_excesses(request), follower_excesses(request)):
        if names:
            top, row, fraction = bernstein.peak(_rows(excesses), DUST / 100)
            which, piece = divmod(row, request.trajectory.num_pieces)
            if not top <= worst.value:
                time, passed = _time(request, piece, fraction), top <= DUST
                worst = Check("position", top, DUST, "rad or m", 0.0, passed, names[which], time)
    return worst


def _own_excesses(request: CertifyRequest) -> tuple[list[str], Array]:
    """Return coordinate names, and excesses of the group over its bounds as coefficients."""
    limits, names = request.limits, request.group.position_names
    iq, iv = request.group.plain
    bases = request.trajectory.bases.T[iq]
    values = request.forms[0][iv] + bases[:, :, None]
    hidden = request.rounding[0][iv] + 2 * UNIT * np.abs(bases).max(axis=1)
    upper, lower = limits.upper[iq], limits.lower[iq]
    above, below = np.flatnonzero(np.isfinite(upper)), np.flatnonzero(np.isfinite(lower))
    excesses = np.empty((len(above) + len(below), *values.shape[1:]))
    most, least = (upper - hidden)[above], (lower + hidden)[below]
    np.subtract(values[above], most[:, None, None], out=excesses[: len(above)])
    np.subtract(least[:, None, None], values[below], out=excesses[len(above) :])
    return [names[i] for i in (*iq[above].tolist(), *iq[below].tolist())], excesses


def rate_check(request: CertifyRequest, name: str, order: int) -> Check:
    """Return the check of peak over limit of velocity (1), acceleration (2) or jerk (3).

    The peak is that of each block's norm, and for accelerations with bounds by sign also the lowest
    and highest value. The value is a guaranteed bound, for floating joints on the true angular
    velocity and its derivatives, not on the tangent's.
    """
    worst = Check(name, 0.0, MAX_UTILISATION, "1", 0.0, passed=True)
    found = [*_utilisations(request, name, order), *follower_uses(request, name, order)]
    if order == 2:
        found += _signed_utilisations(request)
    for used, block, piece, fraction in found:
        if not used <= worst.value:
            time, passed = _time(request, piece, fraction), used <= MAX_UTILISATION
            worst = Check(name, used, MAX_UTILISATION, "1", 0.0, passed, block, time)
    return worst


def _utilisations(
    request: CertifyRequest, name: str, order: int
) -> Iterator[tuple[float, str, int, float]]:
    """Yield peak over limit, block, piece and fraction: scalar blocks together, others each."""
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
        shares = request.forms[order][columns] / bounds[:, None, None]
        rows = _rows(np.concatenate([shares, -shares]))
        top, row, fraction = bernstein.peak(rows, _RELATIVE_GAP)
        which, piece = divmod(row % (len(rows) // 2), request.trajectory.num_pieces)
        hidden = float((request.rounding[order][columns] / bounds).max())
        yield max(top, 0.0) + hidden, scalar[which][0], piece, fraction
    if len(scalar) == len(limited):
        return
    turning = turning_blocks(request)
    for block, indices, limit in limited:
        if len(indices) > 1:
            bound_of = _angular_bound if block in turning else _norm_bound
            top, piece, fraction = bound_of(request, indices, order, limit)
            hidden = float(np.linalg.norm(request.rounding[order][indices]))
            yield (top + hidden) / limit, block, piece, fraction


def _signed_utilisations(request: CertifyRequest) -> Iterator[tuple[float, str, int, float]]:
    """Yield the same for accelerations with bounds that differ by sign, for every bounded block."""
    if not request.acceleration_bounds:
        return
    columns = {name: indices[0] for name, indices in request.group.blocks if len(indices) == 1}
    for name, (lowest, highest) in request.acceleration_bounds.items():
        rows, hidden = request.forms[2][columns[name]], request.rounding[2][columns[name]]
        top, row, fraction = bernstein.peak(
            np.concatenate([rows / highest, rows / lowest]), _RELATIVE_GAP
        )
        top = max(top, 0.0) + float(hidden) / min(highest, -lowest)
        yield float(top), name, row % len(rows), fraction


def _norm_bound(
    request: CertifyRequest, indices: list[int], order: int, limit: float, rows: Any = slice(None)
) -> tuple[float, int, float]:
    """Bound the norm of a block's derivative on pieces; return bound, piece and fraction."""
    forms = request.forms[order][indices][:, rows]
    squares = bernstein.square_norm(np.moveaxis(forms, 0, -1))
    top, row, fraction = bernstein.peak(squares, _RELATIVE_GAP * limit**2)
    return float(np.sqrt(max(top, 0.0))), row, fraction


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
    is_fixed = drift <= _LEAST_DRIFT * limit
    found: list[tuple[float, int, float]] = []
    if is_fixed.any():
        rows = np.flatnonzero(is_fixed)
        top, row, fraction = _norm_bound(request, indices, order, limit, rows)
        found.append((top + float(drift[rows].max()), int(rows[row]), fraction))
    if not is_fixed.all():
        rows = np.flatnonzero(~is_fixed)
        coefficients = request.trajectory.coefficients[rows][:, :, indices]
        widths = np.diff(request.trajectory.breaks)[rows]
        top, row, fraction = angular_peak(coefficients, widths, order, 10 * _RELATIVE_GAP * limit)
        found.append((top, int(rows[row]), fraction))
    return max(found, key=lambda entry: entry[0])


def has_fixed_axes(request: CertifyRequest, indices: list[int], limits: list[float]) -> bool:
    """Return whether every piece rotates a floating joint about a fixed axis.

    Args:
        request: The request with the trajectory.
        indices: The joint's angular coordinates in v.
        limits: Limits by order of derivative, from 1: differences below `_LEAST_DRIFT` of them are
            neglected.
    """
    return all(
        bool((_axis_drift(request, indices, order) <= _LEAST_DRIFT * limit).all())
        for order, limit in enumerate(limits, start=1)
    )


def _axis_drift(request: CertifyRequest, indices: list[int], order: int) -> Array:
    curve = request.trajectory
    return axis_drift(curve.coefficients[:, :, indices], np.diff(curve.breaks), order)


def turning_blocks(request: CertifyRequest) -> set[str]:
    """Return the names of the blocks that are angular velocities in space."""
    floating = [joint for joint in request.group.joints if joint.type is JointType.FLOATING]
    return {name for joint in floating for name, indices in joint.blocks if indices[0] == 0}
