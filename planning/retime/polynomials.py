"""Bernstein polynomials: stacks of vector polynomials, bounded by their coefficients.

A polynomial on an interval lies in the convex hull of its Bernstein coefficients, so its norm
nowhere exceeds the largest norm of a coefficient, and meets the first and the last at the ends
(Farouki 2012, section 3). Halving the interval makes the excess about four times smaller.
"""

from functools import cache
from math import comb

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array


def to_bernstein(
    coefficients: Float64[np.ndarray, "n k d"], widths: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, "n k d"]:
    """Return Bernstein coefficients on [0, width] of power-basis polynomials, lowest first."""
    degree = coefficients.shape[1] - 1
    scaled = coefficients * np.vander(widths, degree + 1, increasing=True)[:, :, None]
    return _power_to_bernstein(degree) @ scaled


def bisected_form(
    coefficients: Float64[np.ndarray, "n k d"],
    widths: Float64[np.ndarray, " n"],
    num_bisections: int,
) -> Float64[np.ndarray, "n m d"]:
    """Return Bernstein coefficients on the parts of [0, width] that bisections leave, in a row.

    Lines are not bisected, for they have their largest values at their ends.
    """
    degree = coefficients.shape[1] - 1
    scaled = coefficients * np.vander(widths, degree + 1, increasing=True)[:, :, None]
    return _power_to_bisected(degree, num_bisections if degree > 1 else 0) @ scaled


def halved(polynomials: Float64[np.ndarray, "n k d"]) -> Float64[np.ndarray, "two_n k d"]:
    """Return both halves of every interval, side by side (de Casteljau)."""
    degree = polynomials.shape[1] - 1
    left = _left_half(degree)
    halves = np.stack([left @ polynomials, left[::-1, ::-1] @ polynomials], axis=1)
    return halves.reshape(-1, degree + 1, polynomials.shape[2])


def norms(vectors: Float64[np.ndarray, "*n d"]) -> Float64[np.ndarray, "*n"]:
    """Return Euclidean lengths along the last axis."""
    if vectors.shape[-1] == 1:
        return np.abs(vectors[..., 0])
    return np.sqrt(np.einsum("...d,...d->...", vectors, vectors))


@cache
def _power_to_bernstein(degree: int) -> Array:
    return np.array([
        [comb(i, k) / comb(degree, k) for k in range(degree + 1)] for i in range(degree + 1)
    ])


@cache
def _power_to_bisected(degree: int, num_bisections: int) -> Array:
    parts = _power_to_bernstein(degree)[None]
    for _ in range(num_bisections):
        parts = halved(parts)
    return np.concatenate(parts)


@cache
def _left_half(degree: int) -> Array:
    return np.array([[comb(i, j) / 2.0**i for j in range(degree + 1)] for i in range(degree + 1)])
