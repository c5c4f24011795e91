"""Cut a spline where it cannot be followed without resting."""

from itertools import pairwise
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.curve import JointSpline, derivative

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Relative jump of a derivative that counts as a jump.
_JUMP = 1e-8


def smooth_stretches(spline: JointSpline, smoothness: int) -> list[JointSpline]:
    """Return the parts of a spline with `smoothness` continuous derivatives, in order.

    Each keeps the spline's parameter, so its first break is where the one before it ends.
    """
    edges = [0, *(1 + np.flatnonzero(_jumps(spline, smoothness))).tolist(), spline.num_pieces]
    return [
        JointSpline(
            spline.joints,
            spline.breaks[a : b + 1],
            spline.bases[a:b],
            spline.coefficients[a:b],
        )
        for a, b in pairwise(edges)
    ]


def path_derivatives(
    curve: JointSpline, pieces: Any, local: Float64[np.ndarray, " n"]
) -> tuple[Float64[np.ndarray, "n nv"], Float64[np.ndarray, "n nv"]]:
    """Return dq/ds and d2q/ds2, as Drake's v and vdot, from given pieces.

    Args:
        curve: The path.
        pieces: Which piece each row is on, also where two of them meet, shape (n,).
        local: Parameter relative to the piece's break.
    """
    delta, rate, curvature = (
        _evaluated(derivative(curve.coefficients, order)[pieces], local) for order in range(3)
    )
    if curve.manifold.is_flat:
        return rate, curvature
    q = curve.manifold.plus(curve.bases[pieces], delta)
    return (
        curve.manifold.generalized_velocity(q, delta, rate),
        curve.manifold.generalized_acceleration(q, delta, rate, curvature),
    )


def _jumps(spline: JointSpline, smoothness: int) -> Any:
    """Return for each inner break whether a derivative up to `smoothness` jumps there."""
    pieces = np.arange(spline.num_pieces)
    widths = np.diff(spline.breaks)
    before = path_derivatives(spline, pieces[:-1], widths[:-1])
    after = path_derivatives(spline, pieces[1:], np.zeros(len(widths) - 1))
    jumps = np.zeros(len(widths) - 1, dtype=bool)
    # The whole path has a parameter of length 1, so r' is a fair reference for r'' as well.
    scale = np.full(len(jumps), 1e-300)
    for n in range(smoothness):
        sizes = [np.linalg.norm(side[n], axis=1) for side in (before, after)]
        scale = np.maximum(scale, np.maximum(*sizes))
        jumps |= np.linalg.norm(after[n] - before[n], axis=1) > _JUMP * scale
    return jumps


def _evaluated(coefficients: Array, local: Array) -> Array:
    """Return each row's polynomial at its own argument, by Horner's rule."""
    total = np.array(coefficients[:, -1])
    for k in range(coefficients.shape[1] - 2, -1, -1):
        total = total * local[:, None] + coefficients[:, k]
    return total
