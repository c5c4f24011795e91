"""Taylor series: arithmetic on truncated series of many segments at once.

A series is an array whose first axis runs over segments and whose second one over powers, from 0
up. Products are Cauchy products, so every coefficient within the truncation is exact.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array


def expand_at(
    coefficients: Float64[np.ndarray, "n k nv"], offsets: Float64[np.ndarray, " n"], terms: int
) -> Float64[np.ndarray, "n terms nv"]:
    """Return the first `terms` Taylor coefficients of polynomials about other points.

    Args:
        coefficients: Power basis about 0.
        offsets: Expansion point of each.
        terms: Number of coefficients; beyond the degree they are zero.
    """
    count, length, width = coefficients.shape
    expanded = np.array(coefficients)
    for i in range(length - 1):
        for k in range(length - 2, i - 1, -1):
            expanded[:, k] += offsets[:, None] * expanded[:, k + 1]
    padded = np.zeros((count, terms, width))
    padded[:, : min(terms, length)] = expanded[:, :terms]
    return padded


def derivative(series: Float64[np.ndarray, "n k *d"], order: int) -> Float64[np.ndarray, "n m *d"]:
    """Return the order-th derivative, shorter by `order` terms."""
    for _ in range(order):
        powers = np.arange(1, series.shape[1], dtype=np.float64)
        series = series[:, 1:] * powers.reshape(1, -1, *[1] * (series.ndim - 2))
    return series


def scaled(
    factor: Float64[np.ndarray, "n k"], series: Float64[np.ndarray, "n k *d"]
) -> Float64[np.ndarray, "n k *d"]:
    """Return a scalar series times another series."""
    count, terms = factor.shape
    product = toeplitz(factor) @ series.reshape(count, terms, -1)
    return product.reshape(series.shape)


def toeplitz(series: Float64[np.ndarray, "n k"]) -> Float64[np.ndarray, "n k k"]:
    """Return the lower triangular matrices that multiply by scalar series."""
    terms = series.shape[1]
    matrix = np.zeros((len(series), terms, terms))
    for i in range(terms):
        rows = np.arange(i, terms)
        matrix[:, rows, rows - i] = series[:, i, None]
    return matrix


def product(
    left: Float64[np.ndarray, "n k r m"], right: Float64[np.ndarray, "n k m c"]
) -> Float64[np.ndarray, "n k r c"]:
    """Return the product of matrix series."""
    terms = right.shape[1]
    total = left[:, :1] @ right
    for i in range(1, terms):
        total[:, i:] += left[:, i : i + 1] @ right[:, : terms - i]
    return total


def cross(
    left: Float64[np.ndarray, "n k 3"], right: Float64[np.ndarray, "n k 3"]
) -> Float64[np.ndarray, "n k 3"]:
    """Return the cross product of vector series."""
    return product(skew(left), right[..., None])[..., 0]


def dot(
    left: Float64[np.ndarray, "n k 3"], right: Float64[np.ndarray, "n k 3"]
) -> Float64[np.ndarray, "n k"]:
    """Return the scalar product of vector series."""
    return product(left[..., None, :], right[..., None])[..., 0, 0]


def skew(vectors: Float64[np.ndarray, "*n 3"]) -> Float64[np.ndarray, "*n 3 3"]:
    """Return the cross-product (skew-symmetric) matrices of vectors."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    matrix = np.zeros((*vectors.shape, 3))
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -z, y, -x
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = z, -y, x
    return matrix


def sine_and_cosine(angle: Float64[np.ndarray, "n k"]) -> tuple[Array, Array]:
    """Return the series of sin and cos of a series, from s' = c q' and c' = -s q'."""
    sine, cosine = np.zeros_like(angle), np.zeros_like(angle)
    sine[:, 0], cosine[:, 0] = np.sin(angle[:, 0]), np.cos(angle[:, 0])
    slopes = angle * np.arange(angle.shape[1])
    for k in range(1, angle.shape[1]):
        rates = slopes[:, 1 : k + 1]
        sine[:, k] = (rates * cosine[:, k - 1 :: -1][:, :k]).sum(axis=1) / k
        cosine[:, k] = -(rates * sine[:, k - 1 :: -1][:, :k]).sum(axis=1) / k
    return sine, cosine


def enlarged(rate: Float64[np.ndarray, "n k"]) -> Float64[np.ndarray, "n k_plus_1"]:
    """Return the series with e' = rate e and e(0) = 1, one term longer than the rate."""
    terms = rate.shape[1] + 1
    total = np.zeros((len(rate), terms))
    total[:, 0] = 1.0
    for k in range(1, terms):
        total[:, k] = (rate[:, :k] * total[:, k - 1 :: -1][:, :k]).sum(axis=1) / k
    return total
