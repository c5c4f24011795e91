"""Upper bounds on rates over whole intervals, by Bernstein coefficients.

A polynomial curve on an interval lies in the convex hull of its Bernstein coefficients, so the norm
of no point exceeds the largest norm of a coefficient (Farouki 2012, section 3).
"""

from functools import cache
from math import comb, factorial
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.curve import Curve, derivative
from planning.domain.joints import JointLimits, JointType

type Array = np.ndarray[Any, np.dtype[np.float64]]

_HALVINGS = 3
_SERIES_TERMS = 30


def block_peaks(curve: Curve, limits: JointLimits, order: int) -> Float64[np.ndarray, "n blocks"]:
    """Return a bound on the norm of each block's order-th derivative on each piece.

    Where a floating joint turns about an axis that is not fixed, angular acceleration and jerk
    exceed the plain derivatives of the tangent; see `_turning_excess`.
    """
    widths = np.diff(curve.breaks)
    polynomials = _bernstein(derivative(curve.coefficients, order), widths)
    for _ in range(_HALVINGS):
        polynomials = _halved(polynomials)
    parts = len(polynomials) // len(widths)
    peaks = np.empty((len(widths), len(limits.blocks)))
    for i, block in enumerate(limits.blocks):
        norms = np.linalg.norm(polynomials[:, :, list(block)], axis=2).max(axis=1)
        peaks[:, i] = norms.reshape(len(widths), parts).max(axis=1)
    if order > 1:
        for i in _turning_blocks(curve, limits):
            peaks[:, i] += _turning_excess(curve, list(limits.blocks[i]), order)
    return peaks


def _turning_blocks(curve: Curve, limits: JointLimits) -> list[int]:
    starts: list[int] = []
    offset = 0
    for joint in curve.joints:
        if joint.type is JointType.FLOATING:
            starts.append(offset)
        offset += len(joint.velocity_names)
    return [i for i, block in enumerate(limits.blocks) if block[0] in starts and len(block) == 3]


def _turning_excess(curve: Curve, indices: list[int], order: int) -> Array:
    """Return what d/dt J_r(delta) adds to angular acceleration (2) or jerk (3) on each piece.

    With J_r(x) = sum_k (-1)^k [x]^k / (k+1)! and [delta'] delta' = 0:
    |alpha| - |delta''| <= |delta'|^2 sum_{k>=2} (k-1) |delta|^(k-1) / (k+1)!, and one derivative
    further 3 |delta'| |delta''| sum k |delta|^(k-1) / (k+1)!
    + |delta'|^3 sum k (k-1) |delta|^(k-2) / (k+1)!. Nothing is added where the axis is fixed.
    """
    coefficients = curve.coefficients[:, :, indices]
    widths = np.diff(curve.breaks)
    sizes = [
        np.linalg.norm(_bernstein(derivative(coefficients, n), widths), axis=2).max(axis=1)
        for n in range(order)
    ]
    x = sizes[0]
    if order == 2:
        excess = sizes[1] ** 2 * _sum(x, [(k - 1, k - 1, k + 1) for k in range(2, _SERIES_TERMS)])
    else:
        first = _sum(x, [(k, k - 1, k + 1) for k in range(1, _SERIES_TERMS)])
        second = _sum(x, [(k * (k - 1), k - 2, k + 1) for k in range(2, _SERIES_TERMS)])
        excess = 3 * sizes[1] * sizes[2] * first + sizes[1] ** 3 * second
    # One piece that turns about a moving axis makes the certifier bound all pieces this way.
    return excess if _has_moving_axis(coefficients) else np.zeros_like(excess)


def _has_moving_axis(coefficients: Array) -> bool:
    sizes = np.linalg.norm(coefficients, axis=2)
    longest = coefficients[np.arange(len(coefficients)), np.argmax(sizes, axis=1)]
    across = np.linalg.norm(np.cross(coefficients, longest[:, None]), axis=2).max(axis=1)
    return bool((across > 1e-13 * np.maximum(sizes.max(axis=1) ** 2, 1e-30)).any())


def _sum(x: Array, terms: list[tuple[int, int, int]]) -> Array:
    return sum((w * x**power / factorial(n) for w, power, n in terms), np.zeros_like(x))


def _bernstein(coefficients: Array, widths: Array) -> Array:
    degree = coefficients.shape[1] - 1
    scaled = coefficients * widths[:, None, None] ** np.arange(degree + 1)[None, :, None]
    return np.einsum("ik,nkv->niv", _to_bernstein(degree), scaled)


def _halved(polynomials: Array) -> Array:
    """Return both halves of every interval, side by side."""
    degree = polynomials.shape[1] - 1
    left = _left_half(degree)
    halves = np.stack([left @ polynomials, left[::-1, ::-1] @ polynomials], axis=1)
    return halves.reshape(-1, degree + 1, polynomials.shape[2])


@cache
def _to_bernstein(degree: int) -> Array:
    return np.array([
        [comb(i, k) / comb(degree, k) for k in range(degree + 1)] for i in range(degree + 1)
    ])


@cache
def _left_half(degree: int) -> Array:
    return np.array([[comb(i, j) / 2.0**i for j in range(degree + 1)] for i in range(degree + 1)])
