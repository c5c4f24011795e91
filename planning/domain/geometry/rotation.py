"""Rotations: the exponential map of SO(3), its logarithm and its right Jacobian.

Quaternions are `[w, x, y, z]`. Formulas: Sola, Deray, Atchuthan, "A micro Lie theory for state
estimation in robotics" (2018), eqs. 132-148. All functions take stacks along leading axes.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array

# Angles below this take the series, where differences would cancel [rad].
_SMALL = 1e-4


def multiply(a: Float64[np.ndarray, "*#n 4"], b: Float64[np.ndarray, "*#n 4"]) -> Array:
    """Return the Hamilton product of two quaternions."""
    if a.ndim == b.ndim == 1:
        return np.array(_product(a.tolist(), b.tolist()))
    return _stacked(_product([a[..., i] for i in range(4)], [b[..., i] for i in range(4)]))


def conjugate(a: Float64[np.ndarray, "*n 4"]) -> Float64[np.ndarray, "*n 4"]:
    """Return the inverse of unit quaternions."""
    return a * np.array([1.0, -1.0, -1.0, -1.0])


def normalized(a: Float64[np.ndarray, "n 4"]) -> Float64[np.ndarray, "n 4"]:
    """Return quaternions as unit quaternions with w >= 0."""
    lengths = np.sqrt(np.vecdot(a, a))
    return np.where(a[:, :1] >= 0, a, -a) / lengths[:, None]


def exp(phi: Float64[np.ndarray, "*n 3"]) -> Float64[np.ndarray, "*n 4"]:
    """Return the unit quaternions of rotation vectors [rad]."""
    theta = np.sqrt(np.add.reduce(phi * phi, axis=-1, keepdims=True))
    half_sinc = 0.5 * np.sinc(theta / (2 * np.pi))
    return np.concatenate([np.cos(theta / 2), half_sinc * phi], axis=-1)


def log(a: Float64[np.ndarray, "*n 4"]) -> Float64[np.ndarray, "*n 3"]:
    """Return the rotation vectors [rad] of unit quaternions, of length at most pi."""
    a = np.where(a[..., :1] < 0, -a, a)
    w, xyz = a[..., :1], a[..., 1:]
    sine = np.linalg.norm(xyz, axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, w)
    scale = np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 2.0)
    return scale * xyz


def matrix(a: Float64[np.ndarray, "*n 4"]) -> Float64[np.ndarray, "*n 3 3"]:
    """Return the rotation matrices of unit quaternions."""
    w, x, y, z = a.tolist() if a.ndim == 1 else (a[..., i] for i in range(4))
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    if a.ndim == 1:
        return np.array(rows)
    return _stacked([entry for row in rows for entry in row]).reshape(*a.shape[:-1], 3, 3)


def from_matrix(r: Float64[np.ndarray, "3 3"]) -> Float64[np.ndarray, "4"]:
    """Return the unit quaternion (w >= 0) of a rotation matrix, by its largest component."""
    m: list[list[float]] = r.tolist()
    diagonal = [m[0][0] + m[1][1] + m[2][2], m[0][0], m[1][1], m[2][2]]
    i = int(np.argmax(diagonal))
    skew = [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]]
    if i == 0:
        a = np.array([1 + diagonal[0], *skew])
    else:
        k = i - 1
        a = np.array([skew[k], *(m[k][j] + m[j][k] for j in range(3))])
        a[i] = 1 + 2 * m[k][k] - diagonal[0]
    a = a / math.sqrt(a.dot(a))
    return a if a[0] >= 0 else -a


def from_rpy(rpy: Float64[np.ndarray, "3"]) -> Float64[np.ndarray, "4"]:
    """Return the unit quaternion of roll, pitch, yaw [rad] about fixed x, y, z (URDF's)."""
    # Product of `exp` of rotations about one axis each, without stacks: scenes have thousands.
    half_sinc = 0.5 * np.sinc(np.abs(rpy) / (2 * np.pi))
    nil = (half_sinc * 0.0).tolist()
    w, s = np.cos(np.abs(rpy) / 2).tolist(), (half_sinc * rpy).tolist()
    roll, pitch = (w[0], s[0], nil[0], nil[0]), (w[1], nil[1], s[1], nil[1])
    yaw = (w[2], nil[2], nil[2], s[2])
    return np.array(_product(_product(yaw, pitch), roll))


def rotate(a: Float64[np.ndarray, "*#n 4"], p: Float64[np.ndarray, "*#n 3"]) -> Array:
    """Return the vectors `p` rotated by the unit quaternions `a`."""
    if a.ndim == p.ndim == 1:
        w, *axis = a.tolist()
        t = [2 * x for x in _cross_components(axis, p.tolist())]
        u = _cross_components(axis, t)
        return np.array([x + w * y + z for x, y, z in zip(p.tolist(), t, u, strict=True)])
    axes = a[..., 1:]
    t = 2 * _cross(axes, p)
    return p + a[..., :1] * t + _cross(axes, t)


# Single vectors use plain numbers, stacks use arrays: a call of numpy takes ten times as long as
# its arithmetic on one number.
def _product(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """Return the Hamilton product of two quaternions, component by component."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]


def _cross_components(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """Return the cross product, component by component."""
    ax, ay, az = a
    bx, by, bz = b
    return [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]


def _cross(a: Array, b: Array) -> Array:
    return _stacked(_cross_components([a[..., i] for i in range(3)], [b[..., i] for i in range(3)]))


def _stacked(components: Sequence[Array | np.float64]) -> Array:
    """Return components, all of one shape or all numbers, along a last axis."""
    stacked = np.empty((*components[0].shape, len(components)))
    for i, component in enumerate(components):
        stacked[..., i] = component
    return stacked


def right_jacobian(phi: Float64[np.ndarray, "*#n 3"], x: Float64[np.ndarray, "*#n 3"]) -> Array:
    """Return J_r(phi) x: the body angular velocity of exp(phi(t)) where phi' = x (eq. 143)."""
    theta = np.linalg.norm(phi, axis=-1, keepdims=True)
    cross = _cross(phi, x)
    return x - _b(theta) * cross + _c(theta) * _cross(phi, cross)


def body_acceleration(
    phi: Float64[np.ndarray, "*n 3"],
    rate: Float64[np.ndarray, "*n 3"],
    curvature: Float64[np.ndarray, "*n 3"],
) -> Array:
    """Return the body angular acceleration of exp(phi(t)), with phi' = rate, phi'' = curvature.

    It is J_r(phi) phi'' + (d/dt J_r(phi)) phi', by the product rule on eq. 143.
    """
    theta = np.linalg.norm(phi, axis=-1, keepdims=True)
    theta_rate_times_theta = np.sum(phi * rate, axis=-1, keepdims=True)
    cross = _cross(phi, rate)
    jacobian_rate_term = (
        -_b_slope(theta) * theta_rate_times_theta * cross
        + _c_slope(theta) * theta_rate_times_theta * _cross(phi, cross)
        + _c(theta) * _cross(rate, cross)
    )
    return right_jacobian(phi, curvature) + jacobian_rate_term


def _b(theta: Array) -> Array:
    """(1 - cos theta) / theta^2."""
    return 0.5 * np.sinc(theta / (2 * np.pi)) ** 2


def _c(theta: Array) -> Array:
    """(theta - sin theta) / theta^3."""
    safe = np.maximum(theta, _SMALL)
    return np.where(theta > _SMALL * 100, (safe - np.sin(safe)) / safe**3, 1 / 6 - theta**2 / 120)


def _b_slope(theta: Array) -> Array:
    """b'(theta) / theta."""
    safe = np.maximum(theta, _SMALL)
    slope = (safe * np.sin(safe) - 2 * (1 - np.cos(safe))) / safe**4
    return np.where(theta > _SMALL * 1000, slope, -1 / 12 + theta**2 / 180)


def _c_slope(theta: Array) -> Array:
    """c'(theta) / theta."""
    safe = np.maximum(theta, _SMALL)
    slope = (3 * np.sin(safe) - 2 * safe - safe * np.cos(safe)) / safe**5
    return np.where(theta > _SMALL * 1000, slope, -1 / 60 + theta**2 / 1260)
