"""Quaternion series: Taylor series of the unit quaternion exp(delta / 2) and its angular velocity.

With s = |delta|^2 / 4 the quaternion is (C(s), S(s) delta / 2), C = cos sqrt(s) and
S = sin sqrt(s) / sqrt(s). Both are analytic in s, and their derivatives are

    C' = -S / 2,    2 s S' = C - S,

which give the coefficients of their series along a motion one after another. Then with p the
quaternion's scalar part and v its vector part

    omega = 2 (p v' - p' v - v x v')    (Sola 2017, eq. 199),

in the body's frame.
"""

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals.taylor import cross, derivative, dot, scaled
from planning.domain.arrays import Array


def quaternion_angular_velocity(
    delta: Float64[np.ndarray, "n k 3"],
) -> Float64[np.ndarray, "n m 3"]:
    """Return Taylor coefficients of the angular velocity, one less than those of delta (not 0)."""
    last = delta.shape[1] - 1
    real, vector = _quaternion(delta)
    scalar_rate, vector_rate = derivative(real, 1), derivative(vector, 1)
    real, vector = real[:, :last], vector[:, :last]
    return 2 * (
        scaled(real, vector_rate) - scaled(scalar_rate, vector) - cross(vector, vector_rate)
    )


def _quaternion(delta: Array) -> tuple[Array, Array]:
    """Return the series of the scalar and of the vector part."""
    square = dot(delta, delta) / 4
    slope = square * np.arange(square.shape[1])
    cosine, sine = np.zeros_like(square), np.zeros_like(square)
    half = np.sqrt(square[:, 0])
    cosine[:, 0], sine[:, 0] = np.cos(half), np.sin(half) / half
    for k in range(1, square.shape[1]):
        rates = slope[:, 1 : k + 1]
        cosine[:, k] = -(rates * sine[:, k - 1 :: -1][:, :k]).sum(axis=1) / (2 * k)
        # 2 s S' = (C - S) s', by powers: sum_j 2 s_j (k - j) S_(k-j) = sum_j j s_j (C - S)_(k-j).
        right_side = (rates * (cosine - sine)[:, k - 1 :: -1][:, :k]).sum(axis=1)
        known_terms = square[:, 1:k] * sine[:, k - 1 : 0 : -1] * np.arange(k - 1, 0, -1)
        sine[:, k] = (right_side - 2 * known_terms.sum(axis=1)) / (2 * k * square[:, 0])
    return cosine, scaled(sine, delta) / 2
