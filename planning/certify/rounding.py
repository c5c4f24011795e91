"""How far double precision is off a polynomial: of its Bernstein coefficients, and of its values.

A polynomial sum_k c_k t^k of n terms on [0, w] has Bernstein coefficients b_i = sum_k M_ik c_k w^k
with 0 <= M_ik <= 1. Each product and each partial sum is rounded by u = 2^-53 of itself, so that
the computed b_i are within 4 (n + 1) u S of the true ones, S = sum_k |c_k| w^k, to first order in
u; and so is any value by Horner's rule, within 2 n u S (Higham, "Accuracy and Stability of
Numerical Algorithms", 2002, sections 3.1 and 5.1). Halving takes means, where nothing cancels: each
time the coefficients are rounded by (n + 1) u of the largest, at most 64 times. One more of each
makes up for higher orders and for the rounding of these bounds themselves.

S is much larger than the polynomial where powers of a high degree cancel each other: then neither a
proof nor a controller knows where the motion goes.
"""

from math import comb
from typing import Any

import numpy as np
from jaxtyping import Float64

type Array = np.ndarray[Any, np.dtype[np.float64]]

UNIT = 2.0**-53
_CONVERSION, _HALVINGS = 5, 65
# Up to this degree S is known well enough from the b_i: rounding hides less than 2e-11 of them.
LOW_DEGREE = 7


def rounding(
    largest: Float64[np.ndarray, "n nv"],
    coefficients: Float64[np.ndarray, "n k nv"],
    widths: Float64[np.ndarray, " n"],
) -> Float64[np.ndarray, "n nv"]:
    """Bound how far Bernstein coefficients and values of polynomials are off.

    Args:
        largest: Of each polynomial's Bernstein coefficients the largest absolute value.
        coefficients: Power basis, lowest first.
        widths: Of the intervals [0, w].
    """
    terms = coefficients.shape[1]
    if terms <= LOW_DEGREE + 1:
        sizes = _growth(terms - 1) * largest
    else:
        powers = widths[:, None] ** np.arange(terms)
        sizes = np.einsum("nk,nkv->nv", powers, np.abs(coefficients))
    return (terms + 1) * UNIT * (_CONVERSION * sizes + _HALVINGS * largest)


def _growth(degree: int) -> float:
    """Return what S is at most over the largest |b_i|: 3^degree.

    c_k w^k is C(degree, k) times a k-th difference of the b_i, which is at most 2^k of the largest.
    """
    return float(sum(comb(degree, k) * 2**k for k in range(degree + 1)))
