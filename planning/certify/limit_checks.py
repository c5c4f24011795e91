"""Limits on the whole interval, from the trajectory's polynomials."""

from math import factorial
from typing import Any

import numpy as np

from planning.certify import bernstein
from planning.certify.request import CertifyRequest
from planning.domain.certificate import Check
from planning.domain.joints import JointType

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Utilisation (peak over limit) up to this passes; positions may pass their bounds by DUST.
MAX_UTILISATION = 1 + 1e-6
DUST = 1e-6
_RELATIVE_GAP = 1e-8
_SERIES_TERMS = 40


def position_check(request: CertifyRequest) -> Check:
    """Return by how much any coordinate leaves its limits at worst; negative is to spare.

    Quaternions are exempt: they have no limits.
    """
    curve = request.trajectory
    widths = np.diff(curve.breaks)
    coefficients = bernstein.from_power(curve.coefficients, widths)
    worst = Check("position", -np.inf, DUST, "rad or m", 0.0, passed=True)
    for iq, iv in _plain_coordinates(request):
        lower, upper = request.limits.lower[iq], request.limits.upper[iq]
        values = coefficients[:, :, iv] + curve.bases[:, iq, None]
        for bound, sign in ((upper, 1.0), (lower, -1.0)):
            if not np.isfinite(bound):
                continue
            top, row, fraction = bernstein.peak(sign * (values - bound), DUST / 100)
            if top > worst.value:
                time = float(curve.breaks[row] + fraction * widths[row])
                name = request.group.position_names[iq]
                worst = Check(
                    "position", top, DUST, "rad or m", DUST / 100, top <= DUST, name, time
                )
    return worst


def rate_check(request: CertifyRequest, name: str, order: int) -> Check:
    """Return the peak over limit of a derivative: velocity (1), acceleration (2) or jerk (3)."""
    limits = getattr(request.limits, name)
    curve = request.trajectory
    widths = np.diff(curve.breaks)
    worst = Check(name, 0.0, MAX_UTILISATION, "1", 0.0, passed=True)
    for (block, indices), limit in zip(request.group.blocks, limits, strict=True):
        if not np.isfinite(limit):
            continue
        turning = block.endswith(".angular") and len(indices) == 3
        peak, row, fraction = _block_peak(request, list(indices), order, turning=turning)
        used = peak / float(limit)
        if not used <= worst.value:
            time = float(curve.breaks[row] + fraction * widths[row])
            passed = used <= MAX_UTILISATION
            worst = Check(
                name, used, MAX_UTILISATION, "1", _RELATIVE_GAP * used, passed, block, time
            )
    return worst


def _block_peak(
    request: CertifyRequest, indices: list[int], order: int, *, turning: bool
) -> tuple[float, int, float]:
    """Return a bound on the norm of a block's derivative, its piece and fraction."""
    polynomials = _derivative(request, indices, order)
    if len(indices) == 1:
        both = np.concatenate([polynomials[:, :, 0], -polynomials[:, :, 0]])
        gap = _RELATIVE_GAP * max(float(np.abs(both).max()), 1e-12)
        top, row, fraction = bernstein.peak(both, gap)
        return max(top, 0.0), row % len(polynomials), fraction
    if turning and order > 1 and not _is_geodesic(request, indices):
        return _turning_bound(request, indices, order)
    squares = bernstein.square_norm(polynomials)
    gap = _RELATIVE_GAP * max(float(squares.max()), 1e-12)
    top, row, fraction = bernstein.peak(squares, gap)
    return float(np.sqrt(max(top, 0.0))), row, fraction


def _derivative(request: CertifyRequest, indices: list[int], order: int) -> Array:
    """Return Bernstein coefficients of the order-th derivative of the block's tangent."""
    coefficients = request.trajectory.coefficients[:, :, indices]
    for _ in range(order):
        powers = np.arange(1, coefficients.shape[1], dtype=np.float64)
        coefficients = coefficients[:, 1:] * powers[None, :, None]
        if coefficients.shape[1] == 0:
            coefficients = np.zeros((len(coefficients), 1, len(indices)))
    return bernstein.from_power(coefficients, np.diff(request.trajectory.breaks))


def _is_geodesic(request: CertifyRequest, indices: list[int]) -> bool:
    """Whether every piece turns about one fixed axis, so that rates are plain derivatives."""
    coefficients = request.trajectory.coefficients[:, :, indices]
    sizes = np.linalg.norm(coefficients, axis=2)
    longest = coefficients[np.arange(len(coefficients)), np.argmax(sizes, axis=1)]
    across = np.linalg.norm(np.cross(coefficients, longest[:, None]), axis=2)
    scale = np.maximum(sizes.max(axis=1) ** 2, 1e-30)
    return bool((across.max(axis=1) <= 1e-12 * scale).all())


def _turning_bound(
    request: CertifyRequest, indices: list[int], order: int
) -> tuple[float, int, float]:
    """Bound angular acceleration or jerk of R = R_0 exp(delta(t)), delta of any shape.

    omega = J_r(delta) delta' with J_r(x) = sum_k (-1)^k [x]^k / (k+1)!. Differentiating term by
    term, with [delta'] delta' = 0 and norms of products:
    |alpha| <= |delta''| + |delta'|^2 g(|delta|), g(x) = sum_{k>=2} (k-1) x^(k-1) / (k+1)!;
    |jerk| <= |delta'''| + 3 |delta'| |delta''| g1(|delta|) + |delta'|^3 g2(|delta|),
    g1(x) = sum_{k>=1} k x^(k-1) / (k+1)!, g2(x) = sum_{k>=2} k (k-1) x^(k-2) / (k+1)!.
    Each norm is bounded on its piece by its Bernstein coefficients.
    """
    sizes = [
        np.linalg.norm(_derivative(request, indices, n), axis=2).max(axis=1)
        for n in range(order + 1)
    ]
    if order == 2:
        bounds = sizes[2] + sizes[1] ** 2 * _series(sizes[0], lambda k: k - 1, 1, 2)
    else:
        bounds = (
            sizes[3]
            + 3 * sizes[1] * sizes[2] * _series(sizes[0], lambda k: k, 1, 1)
            + sizes[1] ** 3 * _series(sizes[0], lambda k: k * (k - 1), 2, 2)
        )
    row = int(np.argmax(bounds))
    return float(bounds[row]), row, 0.5


def _series(x: Array, weight: Any, lag: int, first: int) -> Array:
    """Return sum_{k >= first} weight(k) x^(k - lag) / (k + 1)!."""
    terms = range(first, _SERIES_TERMS)
    return sum((weight(k) * x ** (k - lag) / factorial(k + 1) for k in terms), np.zeros_like(x))


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
