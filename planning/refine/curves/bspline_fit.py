"""Least-squares fit of a B-spline to a path: the optimizer's initial guess."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.path import JointPath
from planning.domain.robot.manifold import Manifold
from planning.refine.curves.bspline_basis import position_weights

# More control points make a quicker motion and a slower optimizer; beyond 14 the gain is small.
_CONTROL_POINT_COUNTS = (14, 17, 22, 28)
_NUM_SAMPLES = 161


def unwrapped_waypoints(path: JointPath) -> Array:
    """Return the waypoints with angles that never jump by full turns, shape (n, nq).

    Consecutive waypoints that are the same are merged. The first waypoint is kept as it is.
    """
    steps = Manifold.of(path.group.joints).minus(path.waypoints[1:], path.waypoints[:-1])
    moves = steps[np.linalg.norm(steps, axis=1) > 1e-9]
    return path.waypoints[0] + np.vstack([np.zeros_like(steps[:1]), np.cumsum(moves, axis=0)])


def fit_control_points(
    waypoints: Float64[np.ndarray, "n nq"],
    velocity_limits: Float64[np.ndarray, " nq"],
    tolerance: float = 0.15,
) -> Float64[np.ndarray, "num_control_points nq"]:
    """Return the control points of a clamped cubic B-spline near a polyline, by least squares.

    The polyline is traversed at the velocity limit of its slowest joint. The ends are met exactly.

    Args:
        waypoints: No two consecutive ones the same [rad or m], at least two.
        velocity_limits: Velocity limit of every coordinate [rad/s or m/s].
        tolerance: Control points are added until the fit's largest distance from the path is less
            than this [rad or m], or there are as many as allowed.
    """
    times = np.max(np.abs(np.diff(waypoints, axis=0)) / velocity_limits, axis=1)
    waypoint_times = np.concatenate([[0.0], np.cumsum(times)])
    sample_times = np.linspace(0.0, waypoint_times[-1], _NUM_SAMPLES)
    targets = np.stack(
        [np.interp(sample_times, waypoint_times, column) for column in waypoints.T], axis=1
    )
    fitted = targets
    for num_control_points in _CONTROL_POINT_COUNTS:
        weights = _basis_matrix(num_control_points)
        ends = weights[:, :1] * targets[0] + weights[:, -1:] * targets[-1]
        inner = _inner_fit(num_control_points) @ (targets - ends)
        fitted = np.vstack([targets[:1], inner, targets[-1:]])
        if np.linalg.norm(weights @ fitted - targets, axis=1).max() < tolerance:
            break
    return fitted


@lru_cache(maxsize=8)
def _basis_matrix(num_control_points: int) -> Array:
    """Return every basis function at every sample, shape (num_samples, num_control_points)."""
    weights = position_weights(num_control_points, np.linspace(0.0, 1.0, _NUM_SAMPLES))
    matrix = np.zeros((_NUM_SAMPLES, num_control_points))
    np.put_along_axis(matrix, weights.control_points, weights.values, axis=1)
    matrix.flags.writeable = False
    return matrix


@lru_cache(maxsize=8)
def _inner_fit(num_control_points: int) -> Array:
    """Return what makes the inner control points of samples, shape (n - 2, num_samples)."""
    matrix = np.linalg.pinv(_basis_matrix(num_control_points)[:, 1:-1])
    matrix.flags.writeable = False
    return matrix
