"""Rounding errors in double precision: of Bernstein coefficients, and of polynomial values.

A polynomial sum_k c_k t^k of n terms on [0, w] has Bernstein coefficients b_i = sum_k M_ik c_k w^k
with 0 <= M_ik <= 1. Each product and each partial sum is rounded by u = 2^-53 of itself, so that
the computed b_i are within 4 (n + 1) u S of the true ones, S = sum_k |c_k| w^k, to first order in
u; and so is any value by Horner's rule, within 2 n u S (Higham, "Accuracy and Stability of
Numerical Algorithms", 2002, sections 3.1 and 5.1). Halving takes means, without cancellation: each
time the rounding error of the coefficients is (n + 1) u of the largest, at most 64 times. One more
of each covers higher orders and the rounding of these bounds themselves.

S is much larger than the polynomial where powers of a high degree cancel each other: then the value
is numerically undetermined, for a proof as for a controller.
"""

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals.bernstein import derivative

UNIT_ROUNDOFF = 2.0**-53
_CONVERSION, _HALVINGS = 5, 65
# Up to this degree the b_i bound S well enough: rounding errors are below 5e-9 of them.
LOW_DEGREE = 12


def rounding_bounds(
    largest: Float64[np.ndarray, "*n nv"],
    coefficients: Float64[np.ndarray, "n k nv"],
    widths: Float64[np.ndarray, " n"],
    order: int = 0,
) -> Float64[np.ndarray, "*n nv"]:
    """Bound the rounding errors of Bernstein coefficients and values of polynomials.

    Args:
        largest: Largest absolute Bernstein coefficients: of each polynomial, or of all together.
        coefficients: Power basis, lowest first.
        widths: Widths w of the intervals [0, w].
        order: Order of the derivative.
    """
    terms = max(coefficients.shape[1] - order, 1)
    if terms > LOW_DEGREE + 1:
        return tight_rounding_bounds(largest, coefficients, widths, order)
    # c_k w^k is C(degree, k) times a k-th difference of the b_i: S is at most 3^degree of them.
    return (terms + 1) * UNIT_ROUNDOFF * (_CONVERSION * 3.0 ** (terms - 1) + _HALVINGS) * largest


def tight_rounding_bounds(
    largest: Float64[np.ndarray, "*n nv"],
    coefficients: Float64[np.ndarray, "n k nv"],
    widths: Float64[np.ndarray, " n"],
    order: int = 0,
) -> Float64[np.ndarray, "*n nv"]:
    """Return the bound of `rounding_bounds` with S itself, for low degrees too: tighter, slower."""
    terms = max(coefficients.shape[1] - order, 1)
    powers = widths[:, None] ** np.arange(terms)
    sizes = np.einsum("nk,nkv->nv", powers, np.abs(derivative(coefficients, order)))
    sizes = sizes if largest.ndim > 1 else sizes.max(axis=0)
    return (terms + 1) * UNIT_ROUNDOFF * (_CONVERSION * sizes + _HALVINGS * largest)
