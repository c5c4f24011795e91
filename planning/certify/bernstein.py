"""Polynomials in Bernstein form: rigorous bounds on intervals.

A polynomial on an interval lies between the smallest and the largest of its Bernstein coefficients,
and meets the first and the last at the ends (Farouki, "The Bernstein polynomial basis: a centennial
retrospective", 2012, section 3). Halving the interval makes the bounds four times tighter.
"""

from functools import cache
from math import comb
from typing import Any

import numpy as np
from jaxtyping import Float64

type Array = np.ndarray[Any, np.dtype[np.float64]]

_MAX_HALVINGS = 40
_MAX_NODES = 20_000


def from_power(
    coefficients: Float64[np.ndarray, "n k nv"], widths: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, "n k nv"]:
    """Return Bernstein coefficients on [0, width] of power-basis polynomials, lowest first."""
    degree = coefficients.shape[1] - 1
    scaled = coefficients * widths[:, None, None] ** np.arange(degree + 1)[None, :, None]
    return np.einsum("ik,nkv->niv", _power_to_bernstein(degree), scaled)


def halves(
    bernstein: Float64[np.ndarray, "*n k nv"],
) -> tuple[Float64[np.ndarray, "*n k nv"], Float64[np.ndarray, "*n k nv"]]:
    """Return the coefficients on both halves of the interval (de Casteljau)."""
    left, right = _halving(bernstein.shape[-2] - 1)
    return left @ bernstein, right @ bernstein


def peak(bernstein: Float64[np.ndarray, "n k"], tolerance: float) -> tuple[float, int, float]:
    """Return an upper bound on the largest value of n polynomials, each on its own interval.

    Args:
        bernstein: Coefficients, a row per interval.
        tolerance: How far above the true maximum the bound may lie.

    Returns:
        The bound, the row where it is, and the fraction of that row's interval.
    """
    rows = np.arange(len(bernstein))
    low = np.zeros(len(bernstein))
    width = 1.0
    nodes = bernstein
    for _ in range(_MAX_HALVINGS):
        upper = nodes.max(axis=1)
        reached = np.maximum(nodes[:, 0], nodes[:, -1]).max()
        open_ = upper > reached + tolerance
        if not open_.any() or open_.sum() > _MAX_NODES:
            break
        best = int(np.argmax(np.maximum(nodes[:, 0], nodes[:, -1])))
        keep = open_.copy()
        keep[best] = True
        left, right = halves(nodes[keep][..., None])
        nodes = np.concatenate([left[..., 0], right[..., 0]])
        width /= 2
        low = np.concatenate([low[keep], low[keep] + width])
        rows = np.concatenate([rows[keep], rows[keep]])
    top = int(np.argmax(nodes.max(axis=1)))
    at_end = nodes[top, -1] >= nodes[top, 0]
    return float(nodes[top].max()), int(rows[top]), float(low[top] + (width if at_end else 0.0))


def square_norm(bernstein: Float64[np.ndarray, "n k nv"]) -> Float64[np.ndarray, "n m"]:
    """Return the coefficients, of twice the degree, of the sum of squares over coordinates."""
    degree = bernstein.shape[1] - 1
    weights, target = _product(degree)
    outer = np.einsum("niv,njv->nij", bernstein, bernstein) * weights
    squared = np.zeros((len(bernstein), 2 * degree + 1))
    for i in range(degree + 1):
        squared[:, target[i]] += outer[:, i]
    return squared


@cache
def _power_to_bernstein(degree: int) -> Array:
    matrix = np.zeros((degree + 1, degree + 1))
    for i in range(degree + 1):
        for k in range(i + 1):
            matrix[i, k] = comb(i, k) / comb(degree, k)
    return matrix


@cache
def _halving(degree: int) -> tuple[Array, Array]:
    left = np.zeros((degree + 1, degree + 1))
    for i in range(degree + 1):
        for j in range(i + 1):
            left[i, j] = comb(i, j) / 2.0**i
    return left, left[::-1, ::-1].copy()


@cache
def _product(degree: int) -> tuple[Array, tuple[slice, ...]]:
    """Return weights C(d,i) C(d,j) / C(2d,i+j) and where row i of the products goes."""
    d = degree
    weights = np.array([
        [comb(d, i) * comb(d, j) / comb(2 * d, i + j) for j in range(d + 1)] for i in range(d + 1)
    ])
    return weights, tuple(slice(i, i + d + 1) for i in range(d + 1))
