"""Angular rate bounds: angular rates of a rotation R(t) = R_0 exp(delta(t)) with a moving axis.

In the body's frame omega = J_r(delta) delta', with the series of the right Jacobian (Sola et al.
2018, eq. 143): omega = sum_k (-1)^k / (k + 1)! [delta]^k delta', [a] b = a x b. On Taylor
coefficients, multiplying by [delta] is a lower triangular Toeplitz matrix T, so those of omega are
phi(-T) applied to those of delta', phi(X) = sum_k X^k / (k + 1)!. With every vector replaced by a
bound on its norm and every sign by plus, the same sum bounds the norms of omega's Taylor
coefficients, since |a x b| <= |a| |b|.
"""

from math import factorial
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.retime.polynomials import norms, to_bernstein

# Relative size of components across the axis below which it counts as fixed.
_FIXED = 1e-13
_MAX_TERMS = 80
_SMALL = 1e-17


def has_moving_axis(coefficients: Float64[np.ndarray, "n k 3"]) -> Any:
    """Return for each piece whether delta(t), power basis, leaves the line through zero."""
    sizes = norms(coefficients)
    longest = coefficients[np.arange(len(coefficients)), np.argmax(sizes, axis=1)]
    across = norms(np.cross(coefficients, longest[:, None])).max(axis=1)
    return across > _FIXED * np.maximum(sizes.max(axis=1) ** 2, 1e-30)


def with_derivatives(
    coefficients: Float64[np.ndarray, "n k 3"], widths: Float64[np.ndarray, " n"], order: int
) -> Float64[np.ndarray, "n k d"]:
    """Return Bernstein coefficients of delta and of its derivatives, as input of `rate_bounds`.

    Taken from the power basis: differences of Bernstein coefficients cancel on short intervals.

    Args:
        coefficients: Power basis of delta on each interval [rad], lowest first.
        widths: Lengths of the intervals.
        order: Order of the rate, as in `rate_bounds`.

    Returns:
        All Taylor coefficients up to index order + 2 side by side, d = 3 (order + 3), as functions
        on each interval.
    """
    count = coefficients.shape[1]
    stacked = np.zeros((len(coefficients), count, order + 3, 3))
    term = coefficients
    for k in range(min(order + 3, count)):
        stacked[:, : count - k, k] = term
        powers = np.arange(1, count - k, dtype=np.float64)
        term = term[:, 1:] * powers[None, :, None] / (k + 1)
    return to_bernstein(stacked.reshape(len(coefficients), count, -1), widths)


def rate_bounds(
    polynomials: Float64[np.ndarray, "n k d"], widths: Float64[np.ndarray, " n"], order: int
) -> tuple[Float64[np.ndarray, " n"], Float64[np.ndarray, " n"]]:
    """Bound the norm of a derivative of omega on whole intervals.

    A function is within h^2 / 8 sup |f''| of the chord between its ends, and no point of a chord
    is longer than both its ends.

    Args:
        polynomials: Polynomials of `with_derivatives`, or halves of those.
        widths: Lengths of the intervals.
        order: 1 for omega itself, 2 for its first derivative, 3 for its second: the larger of its
            values in the body's frame and in the world's.

    Returns:
        Upper bounds, and attained values.
    """
    lag = order - 1
    # The second derivatives in the body's frame and in the world's differ.
    signs = (-1.0,) if order < 3 else (-1.0, 1.0)
    taylor = polynomials.reshape(*polynomials.shape[:2], order + 3, 3)
    at_ends = [norms(_angular(taylor[:, end], lag, sign)) for end in (0, -1) for sign in signs]
    attained = np.max(at_ends, axis=0) * factorial(lag)
    sizes = norms(taylor).max(axis=1)
    slopes = sizes[:, 1:] * np.arange(1, sizes.shape[1])
    majorant = _phi(_toeplitz(sizes[:, :-1, None, None]), slopes)[:, lag + 2]
    return attained + widths**2 / 8 * factorial(lag + 2) * majorant, attained


def _angular(taylor: Array, index: int, sign: float) -> Array:
    """Return the Taylor coefficient of omega with a given index, from those of delta.

    In the body's frame with sign -1, in that of R_0 with +1 (the left Jacobian).
    """
    length = index + 1
    x, y, z = np.moveaxis(taylor[:, :length], -1, 0)
    o = np.zeros_like(x)
    skew = np.stack([o, -z, y, z, o, -x, -y, x, o], axis=-1).reshape(len(x), length, 3, 3)
    slopes = taylor[:, 1 : length + 1] * np.arange(1, length + 1)[None, :, None]
    return _phi(sign * _toeplitz(skew), slopes.reshape(len(x), -1))[:, -3:]


def _toeplitz(blocks: Array) -> Array:
    """Return block lower triangular Toeplitz matrices, shape (n, m d, m d)."""
    n, m, d, _ = blocks.shape
    matrix = np.zeros((n, m, d, m, d))
    for j in range(m):
        matrix[:, j:, :, j] = blocks[:, : m - j]
    return matrix.reshape(n, m * d, m * d)


def _phi(matrix: Array, vector: Array) -> Array:
    """Return sum_k X^k / (k + 1)! applied to a vector."""
    term = vector[:, :, None]
    total = term
    for k in range(1, _MAX_TERMS):
        term = matrix @ term / (k + 1)
        total = total + term
        if np.abs(term).max(initial=0.0) <= _SMALL * np.abs(total).max(initial=0.0):
            break
    return total[:, :, 0]
