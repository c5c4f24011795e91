"""Angular rates: rigorous bounds on angular velocity and derivatives of R(t) = R_0 exp(delta(t)).

In the body's frame omega = J_r(delta) delta', with the right Jacobian as a series and as a mean of
rotations (Sola et al. 2018, eq. 143)

    J_r(delta) = sum_{k >= 0} (-1)^k / (k + 1)! ad(delta)^k = int_0^1 exp(-s ad(delta)) ds.

Taylor coefficients of delta about an instant give those of omega: by multiplying the series out
where delta is small, else from the unit quaternion of exp(delta) (`quaternion_series`).

Their size does not depend on delta itself. With delta(t + h) = delta(t) + e(h), Duhamel's formula
expands exp(-s ad(delta + e)) into a sum of integrals over products of rotations and of ad(e), so
that its coefficients are bounded by those of exp(s E), E(h) = sum_{k >= 1} |delta^(k)| h^k / k!,
and those of omega by those of the majorant

    int_0^1 exp(s E) ds E' = sum_{k >= 0} E^k E' / (k + 1)!.

So on |t - t_m| <= h a derivative of omega is its Taylor polynomial, whose length Bernstein
coefficients bound, plus a remainder of at most the majorant's next coefficient times h to its power
(Lagrange). The majorant bounds rounding errors, too: if e_k bounds the error of the coefficients of
delta, the error of those of omega is at most the growth of the majorant when e_k is added to E, e_0
included.
"""

from math import factorial

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals import bernstein
from planning.certify.intervals.quaternion_series import quaternion_angular_velocity
from planning.certify.intervals.rounding import UNIT_ROUNDOFF, rounding_bounds
from planning.certify.intervals.taylor import skew
from planning.domain.arrays import Array

_ORDER = 6
_MAX_HALVINGS = 14
_MAX_INTERVALS = 20_000
# Largest angle at which powers of delta are summed: beyond it cancellation loses digits [rad].
_LARGEST_ANGLE = 3.0
_TERMS = 60
# Bound on the rounding error of all sums and products, relative to their sizes.
_RELATIVE_ROUNDING = 2 * (_TERMS + 2 * _ORDER) * UNIT_ROUNDOFF


def angular_peak(
    coefficients: Float64[np.ndarray, "n k 3"],
    widths: Float64[np.ndarray, " n"],
    order: int,
    tolerance: float,
) -> tuple[float, int, float]:
    """Bound the norm of the angular velocity or of one of its derivatives.

    Args:
        coefficients: Power basis of delta on each piece [rad], lowest first.
        widths: Lengths of the pieces [s].
        order: 1 for angular velocity, 2 for acceleration, 3 for jerk.
        tolerance: Largest excess of the bound over the true peak, if attainable [rad/s^order].

    Returns:
        The bound, the piece where it is attained, and the fraction of that piece. The tolerance is
        exceeded if pieces rotate so far that they would have to be cut into too many parts.
    """
    tangents = _derivatives(coefficients, widths, _ORDER + order + 2)
    rounding_errors = _rounding_errors(tangents, coefficients, widths)
    rows, low, half = np.arange(len(widths)), np.zeros(len(widths)), widths / 2
    taylor, remainder, errors = _taylor_model(tangents, rounding_errors, half, order)
    for _ in range(_MAX_HALVINGS):
        is_coarse = ~(remainder <= tolerance / 2)
        if not is_coarse.any() or len(rows) + is_coarse.sum() > _MAX_INTERVALS:
            break
        tangents = [
            np.concatenate([part[~is_coarse], *bernstein.halves(part[is_coarse])])
            for part in tangents
        ]
        start, step = low[is_coarse], half[is_coarse]
        low = np.concatenate([low[~is_coarse], start, start + step])
        half = np.concatenate([half[~is_coarse], step / 2, step / 2])
        rows = np.concatenate([rows[~is_coarse], rows[is_coarse], rows[is_coarse]])
        taylor, remainder, errors = _taylor_model(tangents, rounding_errors[rows], half, order)
    squares = bernstein.square_norm(bernstein.about_middle(taylor, half))
    scale = float(np.sqrt(max(squares[:, [0, -1]].max(), 0.0)))
    top, at, fraction = bernstein.peak(squares, tolerance * max(scale, tolerance) / 2)
    time = (low[at] + fraction * 2 * half[at]) / widths[rows[at]]
    error = float((remainder + errors).max())
    return float(np.sqrt(max(top, 0.0))) + error, int(rows[at]), min(float(time), 1.0)


def _derivatives(coefficients: Array, widths: Array, count: int) -> list[Array]:
    """Return the first Taylor coefficients of the tangent, delta^(k) / k!, as polynomials.

    Each in Bernstein form on its own: differences of one form's coefficients would lose digits.
    """
    return [
        bernstein.from_power(bernstein.derivative(coefficients, k), widths) / factorial(k)
        for k in range(count)
    ]


def _rounding_errors(tangents: list[Array], coefficients: Array, widths: Array) -> Array:
    """Bound the rounding errors of each piece's vectors in `tangents`, shape (n, k)."""
    errors = [
        rounding_bounds(np.abs(part).max(axis=1) * factorial(k), coefficients, widths, k)
        / factorial(k)
        for k, part in enumerate(tangents)
    ]
    return np.linalg.norm(np.stack(errors, axis=1), axis=2)


def _taylor_model(
    tangents: list[Array], rounding_errors: Array, half: Array, order: int
) -> tuple[Array, Array, Array]:
    """Return a derivative's Taylor polynomial about the middle, and a bound on its error.

    The error is the remainder beyond its last power, plus rounding.
    """
    middle = np.stack([bernstein.halves(part)[0][:, -1] for part in tangents], axis=1)
    lengths = [np.linalg.norm(part, axis=2).max(axis=1) for part in tangents]
    bounds = (np.stack(lengths, axis=1) + rounding_errors)[:, :, None]
    bounds[:, 0] = 0.0
    wider = bounds + rounding_errors[:, :, None]
    majorant, wide = (velocity_series(part[..., None], part, 1.0) for part in (bounds, wider))
    num_derivatives = order - 1
    falling = np.array([factorial(j + num_derivatives) / factorial(j) for j in range(_ORDER + 2)])
    taylor = (
        angular_velocity_series(middle)[:, num_derivatives : num_derivatives + _ORDER + 1]
        * falling[None, : _ORDER + 1, None]
    )
    next_coefficient = majorant[:, num_derivatives + _ORDER + 1, 0] * falling[_ORDER + 1]
    angle = np.linalg.norm(middle[:, 0], axis=1)[:, None, None]
    rounding_terms = _RELATIVE_ROUNDING * (np.exp(_LARGEST_ANGLE) + angle) * wide
    coefficient_errors = (wide - majorant + rounding_terms)[
        :, num_derivatives : num_derivatives + _ORDER + 1, 0
    ] * falling[:-1]
    errors = (coefficient_errors * half[:, None] ** np.arange(_ORDER + 1)).sum(axis=1)
    return taylor, next_coefficient * half ** (_ORDER + 1), errors


def angular_velocity_series(delta: Float64[np.ndarray, "n k 3"]) -> Float64[np.ndarray, "n m 3"]:
    """Return Taylor coefficients of omega from those of delta; there is one less."""
    is_small = np.linalg.norm(delta[:, 0], axis=1) <= _LARGEST_ANGLE
    omega = np.empty_like(delta[:, 1:])
    if is_small.any():
        small = delta[is_small]
        omega[is_small] = velocity_series(skew(small), small, -1.0)
    if not is_small.all():
        omega[~is_small] = quaternion_angular_velocity(delta[~is_small])
    return omega


def velocity_series(adjoint: Array, delta: Array, sign: float) -> Array:
    """Return Taylor coefficients of omega from those of delta, or of the majorant.

    Args:
        adjoint: Matrices of ad for each coefficient of delta (vector product), shape (n, k, c, c).
        delta: Coefficients, shape (n, k, c).
        sign: Sign of ad in the series.
    """
    count, length, width = len(delta), delta.shape[1] - 1, delta.shape[2]
    # Multiplication by the whole polynomial: a lower block-triangular Toeplitz matrix.
    product = np.zeros((count, length, width, length, width))
    for i in range(length):
        rows = np.arange(i, length)
        product[:, rows, :, rows - i] = adjoint[:, i]
    product = product.reshape(count, length * width, length * width)
    term = (delta[:, 1:] * np.arange(1, length + 1)[None, :, None]).reshape(count, -1, 1)
    total = term
    for k in range(1, _TERMS):
        term = (sign / (k + 1)) * (product @ term)
        total = total + term
        if np.abs(term).max() <= 1e-18 * np.abs(total).max():
            break
    return total.reshape(count, length, width)
