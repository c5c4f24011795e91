"""Bernstein products: products and degree elevation of polynomials, a row of coefficients for each.

After scaling every coefficient by its binomial, a product is a convolution, and degree elevation is
multiplication by one (Farouki 2012, section 4).
"""

from functools import cache
from math import comb

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array


def multiply(a: Float64[np.ndarray, "n i"], b: Float64[np.ndarray, "n j"]) -> Array:
    """Return the Bernstein coefficients of products of rows; the degrees add up."""
    if b.shape[1] < a.shape[1]:
        a, b = b, a
    scaled, other = a * _binomials(a.shape[1] - 1), b * _binomials(b.shape[1] - 1)
    product = np.zeros((len(a), a.shape[1] + b.shape[1] - 1))
    for i in range(a.shape[1]):
        product[:, i : i + b.shape[1]] += scaled[:, i, None] * other
    return product / _binomials(product.shape[1] - 1)


def elevate_degree(a: Float64[np.ndarray, "n i"], degree: int) -> Array:
    """Return the coefficients of the same polynomials, elevated to a degree no smaller."""
    return multiply(a, np.ones((len(a), degree - a.shape[1] + 2)))


@cache
def _binomials(degree: int) -> Array:
    return np.array([float(comb(degree, i)) for i in range(degree + 1)])
