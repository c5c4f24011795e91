"""Rigorous bounds on angular velocity and its derivatives along R(t) = R_0 exp(delta(t)).

In the body's frame omega = J_r(delta) delta', with the series of the right Jacobian (Sola et al.
2018, eq. 143)

    omega = sum_{k >= 0} (-1)^k / (k + 1)! ad(delta)^k delta',   ad(a) b = a x b.

Taylor coefficients of delta give those of omega by multiplying the series out. Replacing every
vector by a bound on its length, x by the product and every sign by plus, the same sum bounds the
lengths of omega's Taylor coefficients, since |a x b| <= |a| |b|: a majorant. So on |t - t_m| <= h
a derivative of omega is its Taylor polynomial, whose length Bernstein coefficients bound, plus a
remainder of at most the majorant's next coefficient times h to its power (Lagrange).

The majorant says what rounding does, too: where no coefficient of delta is off by more than e_k,
those of omega are off by no more than the majorant of sizes that are larger by e_k has more.
"""

from math import factorial
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.certify import bernstein
from planning.certify.rounding import UNIT, rounding
from planning.certify.taylor import skew
from planning.certify.turn_bounds import turn_bounds

type Array = np.ndarray[Any, np.dtype[np.float64]]

_ORDER = 6
_MAX_HALVINGS = 8
# Beyond this the series loses too many digits to say anything [rad].
_LARGEST_ANGLE = 12.0
_COARSE_HALVINGS = 5
_TERMS = 60
# What the rounding of so many sums and products is less than, as a share of their sizes.
_ROUNDED = 2 * (_TERMS + 2 * _ORDER) * UNIT


def angular_peak(
    coefficients: Float64[np.ndarray, "n k 3"],
    widths: Float64[np.ndarray, " n"],
    order: int,
    tolerance: float,
) -> tuple[float, int, float]:
    """Bound the length of a derivative of the angular velocity.

    Args:
        coefficients: Power basis of delta on each piece [rad], lowest first.
        widths: Lengths of the pieces [s].
        order: 1 for angular velocity, 2 for acceleration, 3 for jerk.
        tolerance: How far above the true peak the bound should lie at most [rad/s^order].

    Returns:
        The bound, the piece where it is, and the fraction of that piece. A piece that turns
        farther than the series can be trusted is bounded more coarsely, by sizes alone.
    """
    tangents = _derivatives(coefficients, widths, _ORDER + order + 2)
    hidden = _hidden(tangents, coefficients, widths)
    is_far = np.linalg.norm(tangents[0], axis=2).max(axis=1) > _LARGEST_ANGLE
    found: list[tuple[float, int, float]] = []
    if is_far.any():
        pieces = np.flatnonzero(is_far)
        tops = _coarse_peaks([part[pieces] for part in tangents], hidden[pieces], order)
        row = int(np.argmax(tops))
        found.append((float(tops[row]), int(pieces[row]), 0.5))
    if not is_far.all():
        pieces = np.flatnonzero(~is_far)
        near = [part[pieces] for part in tangents], hidden[pieces]
        top, row, fraction = _series_peak(near, widths[pieces], order, tolerance)
        found.append((top, int(pieces[row]), fraction))
    return max(found, key=lambda entry: entry[0])


def _coarse_peaks(tangents: list[Array], hidden: Array, order: int) -> Array:
    """Bound every piece by the sizes of the tangent's derivatives on parts of it."""
    parts = [part * factorial(k) for k, part in enumerate(tangents[: order + 1])][1:]
    for _ in range(_COARSE_HALVINGS):
        parts = [np.stack(bernstein.halves(part), axis=1) for part in parts]
        parts = [part.reshape(-1, *part.shape[2:]) for part in parts]
    sizes = np.stack([np.linalg.norm(part, axis=2).max(axis=1) for part in parts])
    off = [hidden[:, k] * factorial(k) for k in range(1, order + 1)]
    sizes += np.repeat(off, 2**_COARSE_HALVINGS, axis=1)
    return turn_bounds(sizes)[order - 1].reshape(len(tangents[0]), -1).max(axis=1)


def _series_peak(
    near: tuple[list[Array], Array], widths: Array, order: int, tolerance: float
) -> tuple[float, int, float]:
    tangents, hidden = near
    rows, low, half = np.arange(len(widths)), np.zeros(len(widths)), widths / 2
    taylor, remainder, errors = _model(tangents, hidden, half, order)
    for _ in range(_MAX_HALVINGS):
        coarse = remainder > tolerance / 2
        if not coarse.any():
            break
        tangents = [
            np.concatenate([part[~coarse], *bernstein.halves(part[coarse])]) for part in tangents
        ]
        start, step = low[coarse], half[coarse]
        low = np.concatenate([low[~coarse], start, start + step])
        half = np.concatenate([half[~coarse], step / 2, step / 2])
        rows = np.concatenate([rows[~coarse], rows[coarse], rows[coarse]])
        taylor, remainder, errors = _model(tangents, hidden[rows], half, order)
    squares = bernstein.square_norm(bernstein.about_middle(taylor, half))
    scale = float(np.sqrt(max(squares[:, [0, -1]].max(), 0.0)))
    top, at, fraction = bernstein.peak(squares, tolerance * max(scale, tolerance) / 2)
    time = (low[at] + fraction * 2 * half[at]) / widths[rows[at]]
    missed = float((remainder + errors).max())
    return float(np.sqrt(max(top, 0.0))) + missed, int(rows[at]), min(float(time), 1.0)


def _derivatives(coefficients: Array, widths: Array, count: int) -> list[Array]:
    """Return the first Taylor coefficients of the tangent, delta^(k) / k!, as polynomials.

    Each in Bernstein form on its own: differences of one form's coefficients would lose digits.
    """
    return [
        bernstein.from_power(bernstein.derivative(coefficients, k), widths) / factorial(k)
        for k in range(count)
    ]


def _hidden(tangents: list[Array], coefficients: Array, widths: Array) -> Array:
    """Bound how far each piece's vectors in `tangents` are off, shape (n, k)."""
    off = [
        rounding(np.abs(part).max(axis=1) * factorial(k), coefficients, widths, k) / factorial(k)
        for k, part in enumerate(tangents)
    ]
    return np.linalg.norm(np.stack(off, axis=1), axis=2)


def _model(
    tangents: list[Array], hidden: Array, half: Array, order: int
) -> tuple[Array, Array, Array]:
    """Return the derivative's Taylor polynomial about the middle, and what it misses at most.

    That is, beyond its last power, and by rounding.
    """
    middle = np.stack([bernstein.halves(part)[0][:, -1] for part in tangents], axis=1)
    lengths = [np.linalg.norm(part, axis=2).max(axis=1) for part in tangents]
    bounds = (np.stack(lengths, axis=1) + hidden)[:, :, None]
    wider = bounds + hidden[:, :, None]
    omega = velocity_series(skew(middle), middle, -1.0)
    majorant, wide = (velocity_series(part[..., None], part, 1.0) for part in (bounds, wider))
    lag = order - 1
    falling = np.array([factorial(j + lag) / factorial(j) for j in range(_ORDER + 2)])
    taylor = omega[:, lag : lag + _ORDER + 1] * falling[None, : _ORDER + 1, None]
    beyond = majorant[:, lag + _ORDER + 1, 0] * falling[_ORDER + 1]
    off = (wide - majorant + _ROUNDED * wide)[:, lag : lag + _ORDER + 1, 0] * falling[:-1]
    errors = (off * half[:, None] ** np.arange(_ORDER + 1)).sum(axis=1)
    return taylor, beyond * half ** (_ORDER + 1), errors


def velocity_series(adjoint: Array, delta: Array, sign: float) -> Array:
    """Return Taylor coefficients of omega from those of delta, or of the majorant.

    Args:
        adjoint: What multiplies a coefficient of delta with another vector, shape (n, k, c, c).
        delta: Coefficients, shape (n, k, c).
        sign: Of ad in the series.
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
