"""Fit a B-spline to a path: the optimiser's initial guess."""

from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.math import BsplineBasis, KnotVectorType
from pydrake.trajectories import BsplineTrajectory

from planning.domain.manifold import Manifold
from planning.domain.path import JointPath

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Cubic pieces: the acceleration is continuous, which is what both retimers need.
ORDER = 4
# More control points make a quicker motion and a slower optimiser; past 14 little is gained.
_COUNTS = (14, 17)
# A fit that strays less from the path [rad or m] is near enough to start from.
_CLOSE = 0.15
_NUM_SAMPLES = 161


def unwrapped(path: JointPath) -> Array:
    """Return the waypoints with angles that never jump by whole turns, shape (n, nq).

    Consecutive waypoints that are the same are merged. The first waypoint is kept as it is.
    """
    steps = Manifold(path.group.joints).minus(path.waypoints[1:], path.waypoints[:-1])
    moves = steps[np.linalg.norm(steps, axis=1) > 1e-9]
    return path.waypoints[0] + np.vstack([np.zeros_like(steps[:1]), np.cumsum(moves, axis=0)])


def fit_control_points(
    waypoints: Float64[np.ndarray, "n nq"], speeds: Float64[np.ndarray, " nq"]
) -> Float64[np.ndarray, "num_control_points nq"]:
    """Return the control points of a clamped cubic B-spline near a polyline, by least squares.

    The polyline is followed at the pace of its slowest joint. The ends are met exactly.

    Args:
        waypoints: No two consecutive ones the same [rad or m], at least two.
        speeds: Velocity limit of every coordinate [rad/s or m/s].
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
        if np.linalg.norm(weights @ fitted - wanted, axis=1).max() < _CLOSE:
            break
    return fitted


def spline_of(
    control_points: Float64[np.ndarray, "n nq"], duration: float = 1.0
) -> BsplineTrajectory:
    """Return Drake's clamped uniform cubic B-spline on [0, duration]."""
    count = len(control_points)
    basis = BsplineBasis(ORDER, count, KnotVectorType.kClampedUniform, 0.0, duration)
    return BsplineTrajectory(basis, [point[:, None] for point in control_points])


@lru_cache(maxsize=8)
def _weights(count: int) -> Array:
    """Return every basis function at every sample, shape (samples, count)."""
    basis = BsplineBasis(ORDER, count, KnotVectorType.kClampedUniform, 0.0, 1.0)
    weights = [
        [basis.EvaluateBasisFunctionI(i, float(s)) for i in range(count)]
        for s in np.linspace(0.0, 1.0, _NUM_SAMPLES)
    ]
    matrix = np.array(weights)
    matrix.flags.writeable = False
    return matrix
