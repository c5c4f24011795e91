"""Bernstein form of polynomials: rigorous bounds on intervals.

A polynomial on an interval lies between the smallest and the largest of its Bernstein coefficients,
and meets the first and the last at the ends (Farouki, "The Bernstein polynomial basis: a centennial
retrospective", 2012, section 3). Halving the interval makes the bounds four times tighter.
Computed coefficients have rounding errors: `rounding` bounds them, and every proof adds that bound.
"""

from functools import cache
from math import comb

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.kernel.native import native

_MAX_HALVINGS = 40
_MAX_NODES = 20_000


def from_power(
    coefficients: Float64[np.ndarray, "n k nv"], widths: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, "n k nv"]:
    """Return Bernstein coefficients on [0, width] of power-basis polynomials, lowest first."""
    degree = coefficients.shape[1] - 1
    scaled = coefficients * widths[:, None, None] ** np.arange(degree + 1)[None, :, None]
    return np.einsum("ik,nkv->niv", _power_to_bernstein(degree), scaled)


def rows_from_power(
    coefficients: Float64[np.ndarray, "n k nv"], widths: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, "nv n k"]:
    """Return Bernstein coefficients as rows: k coefficients for every coordinate and piece."""
    return _rows(coefficients, widths[:, None] ** np.arange(coefficients.shape[1]))


def derivative_rows(
    coefficients: Float64[np.ndarray, "n k nv"], widths: Float64[np.ndarray, " n"], count: int
) -> tuple[Array, ...]:
    """Return such rows of polynomials and of their first `count` - 1 derivatives."""
    powers = widths[:, None] ** np.arange(coefficients.shape[1])
    found = [_rows(coefficients, powers)]
    for _ in range(1, count):
        coefficients = derivative(coefficients, 1)
        found.append(_rows(coefficients, powers[:, : coefficients.shape[1]]))
    return tuple(found)


def _rows(coefficients: Array, powers: Array) -> Array:
    count, terms, width = coefficients.shape
    scaled = coefficients.transpose(2, 0, 1) * powers
    rows = scaled.reshape(-1, terms) @ _power_to_bernstein(terms - 1).T
    return rows.reshape(width, count, terms)


def about_middle(
    taylor: Float64[np.ndarray, "n k nv"], half_widths: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, "n k nv"]:
    """Return Bernstein coefficients on [-h, h] of power-basis polynomials, lowest first."""
    degree = taylor.shape[1] - 1
    scaled = taylor * half_widths[:, None, None] ** np.arange(degree + 1)[None, :, None]
    shifted = np.einsum("ik,nkv->niv", _unit_to_symmetric(degree), scaled)
    return np.einsum("ik,nkv->niv", _power_to_bernstein(degree), shifted)


def halves(
    bernstein: Float64[np.ndarray, "*n k nv"],
) -> tuple[Float64[np.ndarray, "*n k nv"], Float64[np.ndarray, "*n k nv"]]:
    """Return the coefficients on both halves of the interval (de Casteljau)."""
    left, right = _halving(bernstein.shape[-2] - 1)
    return left @ bernstein, right @ bernstein


def derivative(
    coefficients: Float64[np.ndarray, "n k nv"], order: int
) -> Float64[np.ndarray, "n m nv"]:
    """Return power-basis coefficients of the order-th derivative; at least one, possibly 0."""
    for _ in range(order):
        powers = np.arange(1, coefficients.shape[1], dtype=np.float64)
        coefficients = coefficients[:, 1:] * powers[None, :, None]
    if coefficients.shape[1] == 0:
        return np.zeros((coefficients.shape[0], 1, coefficients.shape[2]))
    return coefficients


def peak(
    bernstein: Float64[np.ndarray, "n k"], tolerance: float, *, use_kernel: bool = True
) -> tuple[float, int, float]:
    """Return an upper bound on the maximum of n polynomials, each on its own interval.

    Branch and bound: intervals whose largest coefficient exceeds the largest value at any interval
    end by more than `tolerance` are halved, the others are dropped.

    Args:
        bernstein: Coefficients, a row per interval.
        tolerance: Largest excess of the bound over the true maximum.
        use_kernel: Whether the native kernel may be used, if it is available.

    Returns:
        The bound, the row where it is attained, and the fraction of that row's interval. The bound
        always holds; it is within the tolerance unless too many intervals stay undecided.
    """
    module = native() if use_kernel else None
    if module is not None:
        return module.peak(np.ascontiguousarray(bernstein), tolerance)
    return _peak(bernstein, tolerance)


def _peak(bernstein: Float64[np.ndarray, "n k"], tolerance: float) -> tuple[float, int, float]:
    rows, low = np.arange(len(bernstein)), np.zeros(len(bernstein))
    width, nodes, decided_bound = 1.0, bernstein, -np.inf
    for _ in range(_MAX_HALVINGS):
        upper, ends = nodes.max(axis=1), np.maximum(nodes[:, 0], nodes[:, -1])
        best = int(np.argmax(ends))
        is_undecided = upper > ends[best] + tolerance
        if not is_undecided.any() or is_undecided.sum() > _MAX_NODES:
            break
        is_undecided[best] = True
        decided_bound = max(decided_bound, float(upper[~is_undecided].max(initial=-np.inf)))
        left, right = halves(nodes[is_undecided][..., None])
        nodes = np.concatenate([left[..., 0], right[..., 0]])
        width /= 2
        low = np.concatenate([low[is_undecided], low[is_undecided] + width])
        rows = np.concatenate([rows[is_undecided], rows[is_undecided]])
    top = int(np.argmax(nodes.max(axis=1)))
    at_end = nodes[top, -1] >= nodes[top, 0]
    bound = max(float(nodes[top].max()), decided_bound)
    return bound, int(rows[top]), float(low[top] + (width if at_end else 0.0))


def square_norm(bernstein: Float64[np.ndarray, "n k nv"]) -> Float64[np.ndarray, "n m"]:
    """Return Bernstein coefficients, of twice the degree, of the squared norm over coordinates."""
    degree = bernstein.shape[1] - 1
    outer = np.einsum("niv,njv->nij", bernstein, bernstein) * _product(degree)
    squared = np.zeros((len(bernstein), 2 * degree + 1))
    for i in range(degree + 1):
        squared[:, i : i + degree + 1] += outer[:, i]
    return squared


@cache
def _power_to_bernstein(degree: int) -> Array:
    matrix = np.zeros((degree + 1, degree + 1))
    for i in range(degree + 1):
        for k in range(i + 1):
            matrix[i, k] = comb(i, k) / comb(degree, k)
    return matrix


@cache
def _unit_to_symmetric(degree: int) -> Array:
    """Return the matrix that maps coefficients in x to those in u, x = 2 u - 1."""
    matrix = np.zeros((degree + 1, degree + 1))
    for k in range(degree + 1):
        for j in range(k + 1):
            matrix[j, k] = comb(k, j) * 2.0**j * (-1.0) ** (k - j)
    return matrix


@cache
def _halving(degree: int) -> tuple[Array, Array]:
    left = np.zeros((degree + 1, degree + 1))
    for i in range(degree + 1):
        for j in range(i + 1):
            left[i, j] = comb(i, j) / 2.0**i
    return left, left[::-1, ::-1].copy()


@cache
def _product(degree: int) -> Array:
    """Return the weights C(d,i) C(d,j) / C(2d,i+j) of products of coefficients."""
    d = degree
    return np.array([
        [comb(d, i) * comb(d, j) / comb(2 * d, i + j) for j in range(d + 1)] for i in range(d + 1)
    ])
