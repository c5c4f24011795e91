"""Axis drift: difference of angular rates and tangent derivatives for an almost fixed axis.

On a piece with a fixed rotation axis, omega = delta'. In general, with D = delta x delta' and the
series of the right Jacobian (Sola et al. 2018, eq. 143),

    omega - delta' = sum_{k >= 1} (-1)^k / (k + 1)! ad(delta)^(k - 1) D,

so with f(x) = sum_{k >= 1} x^(k - 1) / (k + 1)! = (e^x - 1 - x) / x^2, x = |delta|, and since each
derivative of ad(delta)^(k - 1) brings one factor |delta'| for one factor x,

    |omega   - delta'|   <= f |D|,
    |omega'  - delta''|  <= f |D'| + f' a |D|,
    |omega'' - delta'''| <= f |D''| + 2 f' a |D'| + (f'' a^2 + f' b) |D|,

with bounds a, b on |delta'| and |delta''|. Rounding errors (`rounding`) are added to all sizes.
"""

from math import factorial

import numpy as np
from jaxtyping import Float64
from numpy.polynomial.polynomial import polyder, polyval

from planning.certify.intervals import bernstein
from planning.certify.intervals.rounding import UNIT_ROUNDOFF, rounding_bounds
from planning.domain.arrays import Array

# Number of terms of the series, and largest angle at which they are exact to rounding [rad].
_TERMS, _LARGEST_ANGLE = 100, 20.0


def axis_drift(
    coefficients: Float64[np.ndarray, "n k 3"], widths: Float64[np.ndarray, " n"], order: int
) -> Float64[np.ndarray, " n"]:
    """Bound |omega^(order - 1) - delta^(order)| on every piece [rad/s^order].

    Args:
        coefficients: Power basis of delta [rad], lowest first.
        widths: Lengths of the pieces [s].
        order: 1 for angular velocity, 2 for acceleration, 3 for jerk.
    """
    # In the piece's normalized time u = t / width, so that coefficients compare in size.
    scaled = coefficients * (widths[:, None] ** np.arange(coefficients.shape[1]))[:, :, None]
    x, a, b = (_max_norm(scaled, k) for k in range(3))
    cross_products = _cross_products(scaled)
    drift = [_max_norm(cross_products, k) + _rounding_error(scaled, k) for k in range(3)]
    with np.errstate(over="ignore", invalid="ignore"):
        f, first_derivative, second_derivative = _series(x)
        bounds = (
            f * drift[0],
            f * drift[1] + first_derivative * a * drift[0],
            f * drift[2]
            + 2 * first_derivative * a * drift[1]
            + (second_derivative * a**2 + first_derivative * b) * drift[0],
        )
        bound = bounds[order - 1] / widths**order
    return np.where(np.isfinite(bound), bound, np.inf)


def _max_norm(power: Array, order: int) -> Array:
    """Return the largest norm of a derivative of a vector polynomial on each piece."""
    ones = np.ones(len(power))
    form = bernstein.from_power(bernstein.derivative(power, order), ones)
    errors = rounding_bounds(np.abs(form).max(axis=1), power, ones, order)
    return np.linalg.norm(form, axis=2).max(axis=1) + np.linalg.norm(errors, axis=1)


def _cross_products(scaled: Array) -> Array:
    """Return the power basis of delta x delta'."""
    count, terms, _ = scaled.shape
    rates = bernstein.derivative(scaled, 1)
    products = np.zeros((count, terms + rates.shape[1] - 1, 3))
    for i in range(terms):
        for k in range(rates.shape[1]):
            products[:, i + k] += np.cross(scaled[:, i], rates[:, k])
    return products


def _rounding_error(scaled: Array, order: int) -> Array:
    """Bound the rounding error of the order-th derivative of delta x delta'.

    Each power of it is a sum of products, no more than delta has powers, of three roundings each.
    """
    terms = scaled.shape[1]
    sizes = np.linalg.norm(scaled, axis=2)
    sums = sizes.sum(axis=1) * (sizes * np.arange(terms)).sum(axis=1)
    return (terms + 4) * UNIT_ROUNDOFF * (2.0 * terms) ** order * sums


def _series(x: Array) -> tuple[Array, Array, Array]:
    """Return f, f' and f'' at the given sizes; infinite where the sum is truncated too early."""
    f = np.array([1.0 / factorial(k + 2) for k in range(_TERMS)])
    f, first_derivative, second_derivative = (
        np.where(x <= _LARGEST_ANGLE, polyval(x, polyder(f, order)), np.inf) for order in range(3)
    )
    return f, first_derivative, second_derivative
