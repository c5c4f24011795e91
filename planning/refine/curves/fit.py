"""Least-squares fit of a B-spline to a path: the optimiser's initial guess."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.path import JointPath
from planning.domain.robot.manifold import Manifold
from planning.refine.curves.bspline_basis import weights_at

# More control points make a quicker motion and a slower optimiser; beyond 14 the gain is small.
_COUNTS = (14, 17, 22, 28)
_NUM_SAMPLES = 161


def unwrapped(path: JointPath) -> Array:
    """Return the waypoints with angles that never jump by full turns, shape (n, nq).

    Consecutive waypoints that are the same are merged. The first waypoint is kept as it is.
    """
    steps = Manifold.of(path.group.joints).minus(path.waypoints[1:], path.waypoints[:-1])
    moves = steps[np.linalg.norm(steps, axis=1) > 1e-9]
    return path.waypoints[0] + np.vstack([np.zeros_like(steps[:1]), np.cumsum(moves, axis=0)])


def fit_control_points(
    waypoints: Float64[np.ndarray, "n nq"],
    speeds: Float64[np.ndarray, " nq"],
    closeness: float = 0.15,
) -> Float64[np.ndarray, "num_control_points nq"]:
    """Return the control points of a clamped cubic B-spline near a polyline, by least squares.

    The polyline is traversed at the velocity limit of its slowest joint. The ends are met exactly.

    Args:
        waypoints: No two consecutive ones the same [rad or m], at least two.
        speeds: Velocity limit of every coordinate [rad/s or m/s].
        closeness: Control points are added until the fit's largest distance from the path is less
            than this [rad or m], or there are as many as allowed.
    """
    times = np.max(np.abs(np.diff(waypoints, axis=0)) / speeds, axis=1)
    instants = np.concatenate([[0.0], np.cumsum(times)])
    wanted_at = np.linspace(0.0, instants[-1], _NUM_SAMPLES)
    wanted = np.stack([np.interp(wanted_at, instants, column) for column in waypoints.T], axis=1)
    fitted = wanted
    for count in _COUNTS:
        weights = _weights(count)
        ends = weights[:, :1] * wanted[0] + weights[:, -1:] * wanted[-1]
        inner = np.linalg.lstsq(weights[:, 1:-1], wanted - ends)[0]
        fitted = np.vstack([wanted[:1], inner, wanted[-1:]])
        if np.linalg.norm(weights @ fitted - wanted, axis=1).max() < closeness:
            break
    return fitted


@lru_cache(maxsize=8)
def _weights(count: int) -> Array:
    """Return every basis function at every sample, shape (samples, count)."""
    weights = weights_at(count, np.linspace(0.0, 1.0, _NUM_SAMPLES))
    matrix = np.zeros((_NUM_SAMPLES, count))
    np.put_along_axis(matrix, weights.owners, weights.local, axis=1)
    matrix.flags.writeable = False
    return matrix
