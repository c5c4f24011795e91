"""Limits on the whole interval, from the trajectory's polynomials."""

from typing import Any

import numpy as np

from planning.certify import bernstein
from planning.certify.angular_rates import angular_peak
from planning.certify.request import CertifyRequest
from planning.domain.certificate import Check
from planning.domain.joints import JointType

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Utilisation (peak over limit) up to this passes; positions may pass their bounds by DUST.
MAX_UTILISATION = 1 + 1e-6
DUST = 1e-6
_RELATIVE_GAP = 1e-8


def position_check(request: CertifyRequest) -> Check:
    """Return by how much any coordinate leaves its limits at worst; negative is to spare.

    Quaternions are exempt: they have no limits. The value is a guaranteed bound.
    """
    curve = request.trajectory
    widths = np.diff(curve.breaks)
    coefficients = bernstein.from_power(curve.coefficients, widths)
    worst = Check("position", -np.inf, DUST, "rad or m", 0.0, passed=True)
    for iq, iv in _plain_coordinates(request):
        values = coefficients[:, :, iv] + curve.bases[:, iq, None]
        excesses = values - request.limits.upper[iq], request.limits.lower[iq] - values
        for excess in excesses:
            if np.isneginf(excess).all():
                continue
            top, row, fraction = bernstein.peak(excess, DUST / 100)
            if not top <= worst.value:
                time = float(curve.breaks[row] + fraction * widths[row])
                name = request.group.position_names[iq]
                worst = Check("position", top, DUST, "rad or m", 0.0, top <= DUST, name, time)
    return worst


def rate_check(request: CertifyRequest, name: str, order: int) -> Check:
    """Return the peak over limit of a rate: velocity (1), acceleration (2) or jerk (3).

    The norm of a block is meant. The value is a guaranteed bound, for floating joints of the true
    angular velocity and its derivatives, not of the tangent's.
    """
    limits: Array = getattr(request.limits, name)
    widths = np.diff(request.trajectory.breaks)
    worst = Check(name, 0.0, MAX_UTILISATION, "1", 0.0, passed=True)
    turning = _turning_blocks(request)
    for (block, indices), limit in zip(request.group.blocks, limits, strict=True):
        if np.isinf(limit):
            continue
        bound_of = _angular_bound if block in turning else _norm_bound
        peak, row, fraction = bound_of(request, list(indices), order, float(limit))
        used = peak / float(limit)
        if not used <= worst.value:
            time = float(request.trajectory.breaks[row] + fraction * widths[row])
            passed = used <= MAX_UTILISATION
            worst = Check(name, used, MAX_UTILISATION, "1", 0.0, passed, block, time)
    return worst


def _norm_bound(
    request: CertifyRequest, indices: list[int], order: int, limit: float
) -> tuple[float, int, float]:
    """Bound the norm of a block's derivative; return its piece and fraction as well."""
    coefficients = bernstein.derivative(request.trajectory.coefficients[:, :, indices], order)
    polynomials = bernstein.from_power(coefficients, np.diff(request.trajectory.breaks))
    if len(indices) == 1:
        both = np.concatenate([polynomials[:, :, 0], -polynomials[:, :, 0]])
        top, row, fraction = bernstein.peak(both, _RELATIVE_GAP * limit)
        return max(top, 0.0), row % len(polynomials), fraction
    squares = bernstein.square_norm(polynomials)
    top, row, fraction = bernstein.peak(squares, _RELATIVE_GAP * limit**2)
    return float(np.sqrt(max(top, 0.0))), row, fraction


def _angular_bound(
    request: CertifyRequest, indices: list[int], order: int, limit: float
) -> tuple[float, int, float]:
    """Bound the norm of a floating joint's angular rate; return its piece and fraction as well.

    Where every piece turns about one axis, the tangent's own derivatives are the rates.
    """
    if _has_fixed_axes(request, indices):
        return _norm_bound(request, indices, order, limit)
    coefficients = request.trajectory.coefficients[:, :, indices]
    widths = np.diff(request.trajectory.breaks)
    return angular_peak(coefficients, widths, order, 10 * _RELATIVE_GAP * limit)


def _has_fixed_axes(request: CertifyRequest, indices: list[int]) -> bool:
    coefficients = request.trajectory.coefficients[:, :, indices]
    sizes = np.linalg.norm(coefficients, axis=2)
    longest = coefficients[np.arange(len(coefficients)), np.argmax(sizes, axis=1)]
    across = np.linalg.norm(np.cross(coefficients, longest[:, None]), axis=2)
    scale = np.maximum(sizes.max(axis=1) ** 2, 1e-30)
    return bool((across.max(axis=1) <= 1e-12 * scale).all())


def _turning_blocks(request: CertifyRequest) -> set[str]:
    """Return the names of the blocks that are angular velocities in space."""
    floating = [joint for joint in request.group.joints if joint.type is JointType.FLOATING]
    return {name for joint in floating for name, indices in joint.blocks if indices[0] == 0}


def _plain_coordinates(request: CertifyRequest) -> list[tuple[int, int]]:
    """Return (index in q, index in v) of every coordinate that simply adds."""
    pairs: list[tuple[int, int]] = []
    iq = iv = 0
    for joint in request.group.joints:
        if joint.type is JointType.FLOATING:
            pairs += [(iq + 4 + i, iv + 3 + i) for i in range(3)]
        else:
            pairs += [(iq + i, iv + i) for i in range(len(joint.position_names))]
        iq += len(joint.position_names)
        iv += len(joint.velocity_names)
    return pairs
