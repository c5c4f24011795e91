"""Cubic splines with continuous second derivative through waypoints on a manifold."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.robot.joints import Joint
from planning.domain.robot.manifold import Manifold

# Number of waypoints of the polynomial that gives the slope at each end.
_NUM_END_POINTS = 4


def cubic_through(
    joints: tuple[Joint, ...],
    parameters: Float64[np.ndarray, " n"],
    waypoints: Float64[np.ndarray, "n nq"],
) -> JointSpline:
    """Return the cubic spline through waypoints at given parameters.

    The polynomials are in the tangent: of the first waypoint if a joint floats (it turns by less
    than pi from there), else of each piece's own first waypoint. Their second derivatives follow
    from continuity of the first (de Boor, "A practical guide to splines", chapter IV), with slopes
    at both ends from the nearest four waypoints.

    Args:
        joints: Joints of the configurations.
        parameters: Increasing from 0 to 1, n >= 2.
        waypoints: Configurations, without whole turns between neighbours.
    """
    manifold = Manifold(joints)
    steps = manifold.minus(waypoints[1:], waypoints[:-1])
    tangents = np.concatenate([np.zeros_like(steps[:1]), np.cumsum(steps, axis=0)])
    if not manifold.is_flat:
        tangents = manifold.minus(waypoints, waypoints[:1])
    widths = np.diff(parameters)[:, None]
    slopes = _slopes(parameters, tangents)
    rise = np.diff(tangents, axis=0)
    second = (3 * rise / widths - 2 * slopes[:-1] - slopes[1:]) / widths
    third = (slopes[:-1] + slopes[1:] - 2 * rise / widths) / widths**2
    anchor = tangents[:-1] if not manifold.is_flat else np.zeros_like(rise)
    bases = waypoints[:-1] if manifold.is_flat else np.repeat(waypoints[:1], len(rise), axis=0)
    coefficients = np.stack([anchor, slopes[:-1], second, third], axis=1)
    return JointSpline(joints, parameters, bases, coefficients)


def _slopes(x: Array, y: Array) -> Array:
    """Return the derivatives at the knots that make the second derivative continuous."""
    n = len(x)
    h = np.diff(x)
    matrix, right_side = np.eye(n), np.zeros_like(y)
    right_side[0] = _end_slope(x[:_NUM_END_POINTS], y[:_NUM_END_POINTS])
    right_side[-1] = _end_slope(x[::-1][:_NUM_END_POINTS], y[::-1][:_NUM_END_POINTS])
    secants = np.diff(y, axis=0) / h[:, None]
    for i in range(1, n - 1):
        matrix[i, i - 1 : i + 2] = h[i], 2 * (h[i - 1] + h[i]), h[i - 1]
        right_side[i] = 3 * (h[i] * secants[i - 1] + h[i - 1] * secants[i])
    return np.linalg.solve(matrix, right_side)


def _end_slope(x: Array, y: Array) -> Array:
    """Return the derivative at x[0] of the polynomial through all points."""
    powers = np.arange(len(x))
    scale = x[1] - x[0]
    table = ((x - x[0]) / scale)[:, None] ** powers
    return np.linalg.solve(table, y)[1] / scale
