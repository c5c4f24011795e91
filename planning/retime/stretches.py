"""Cut a spline where it cannot be followed without resting."""

from itertools import pairwise
from typing import Any

import numpy as np

from planning.domain.curve import JointSpline

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Relative jump of a derivative that counts as a jump.
_JUMP = 1e-6


def smooth_stretches(spline: JointSpline, smoothness: int) -> list[JointSpline]:
    """Return the parts of a spline with `smoothness` continuous derivatives, in order.

    Each keeps the spline's parameter, so its first break is where the one before it ends. Pieces
    that stand still (a spline of one configuration) are kept.
    """
    cuts = [i for i in range(1, spline.num_pieces) if _jumps(spline, i, smoothness)]
    edges = [0, *cuts, spline.num_pieces]
    return [
        JointSpline(
            spline.joints,
            spline.breaks[a : b + 1],
            spline.bases[a:b],
            spline.coefficients[a:b],
        )
        for a, b in pairwise(edges)
    ]


def _jumps(spline: JointSpline, i: int, smoothness: int) -> bool:
    """Return whether a derivative up to `smoothness` jumps between pieces i - 1 and i."""
    width = spline.breaks[i] - spline.breaks[i - 1]
    before = _derivatives(spline, i - 1, float(width))
    after = _derivatives(spline, i, 0.0)
    speed = max(float(np.linalg.norm(before[0])), float(np.linalg.norm(after[0])), 1e-12)
    scales = (speed, speed**2)
    return any(
        float(np.linalg.norm(after[n] - before[n])) > _JUMP * scales[n] for n in range(smoothness)
    )


def _derivatives(spline: JointSpline, piece: int, x: float) -> tuple[Array, Array]:
    """Return dq/ds and d2q/ds2, as Drake's generalized velocity and acceleration, on a piece."""
    powers = x ** np.arange(spline.coefficients.shape[1])
    coefficients = spline.coefficients[piece]
    delta = powers @ coefficients
    k = np.arange(1, len(coefficients))
    rate = powers[:-1] @ (k[:, None] * coefficients[1:])
    curvature = (
        powers[: len(k) - 1] @ ((k[1:] * k[:-1])[:, None] * coefficients[2:])
        if len(k) > 1
        else np.zeros_like(rate)
    )
    q = spline.manifold.plus(spline.bases[piece], delta)
    return (
        spline.manifold.generalized_velocity(q, delta, rate),
        spline.manifold.generalized_acceleration(q, delta, rate, curvature),
    )
