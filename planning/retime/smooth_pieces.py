"""Smooth pieces: parts of a spline with continuous derivatives; the motion rests between them."""

from itertools import pairwise
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.curves.curve import Curve, JointSpline, derivative
from planning.kernel.native import native
from planning.retime.polynomials import norms

# Smallest relative jump of a derivative that counts as one.
_MIN_JUMP = 1e-8
# Largest number of terms of a polynomial for the kernel.
_MAX_TERMS = 64


def smooth_pieces(spline: JointSpline, smoothness: int) -> list[JointSpline]:
    """Return the parts of a spline with `smoothness` continuous derivatives, in order.

    Each keeps the spline's parameter, so its first break is where the one before it ends.
    """
    begins = _corners(spline, smoothness)
    if not begins:
        return [spline]
    edges = [0, *begins, spline.num_pieces]
    return [
        JointSpline(
            spline.joints,
            spline.breaks[a : b + 1],
            spline.bases[a:b],
            spline.coefficients[a:b],
        )
        for a, b in pairwise(edges)
    ]


def _corners(spline: JointSpline, smoothness: int) -> list[int]:
    """Return the pieces at whose beginning a derivative up to order `smoothness` jumps."""
    module = native()
    terms = spline.coefficients.shape[1]
    if module is not None and spline.manifold.is_flat and 2 <= terms <= _MAX_TERMS:
        corners = module.corners((spline.breaks, spline.coefficients), smoothness)
    else:
        corners = 1 + np.flatnonzero(jumps_in_numpy(spline, smoothness))
    return list(corners.tolist())


def path_derivatives(
    curve: Curve, pieces: Any, local: Float64[np.ndarray, " n"]
) -> tuple[Float64[np.ndarray, "n nv"], Float64[np.ndarray, "n nv"]]:
    """Return dq/ds and d2q/ds2, as Drake's v and vdot, from given pieces.

    Args:
        curve: The path.
        pieces: Index of the piece of each row, also where two pieces meet, shape (n,).
        local: Parameter relative to the piece's break.
    """
    coefficients = curve.coefficients[pieces]
    slopes = derivative(coefficients, 1)
    rate = evaluate_polynomials(slopes, local)
    curvature = evaluate_polynomials(derivative(slopes, 1), local)
    if curve.manifold.is_flat:
        return rate, curvature
    delta = evaluate_polynomials(coefficients, local)
    q = curve.manifold.plus(curve.bases[pieces], delta)
    return (
        curve.manifold.generalized_velocity(q, delta, rate),
        curve.manifold.generalized_acceleration(q, delta, rate, curvature),
    )


def jumps_in_numpy(spline: JointSpline, smoothness: int) -> Any:
    """Return for each inner break whether a derivative up to order `smoothness` jumps there."""
    count = spline.num_pieces - 1
    # Every inner break on the piece before it, then every one on the piece after it.
    pieces = np.concatenate([np.arange(count), np.arange(1, count + 1)])
    local = np.concatenate([np.diff(spline.breaks)[:-1], np.zeros(count)])
    jumps = np.zeros(count, dtype=bool)
    # The parameter of the whole path has length 1, so r' is a reference for the size of r'' as
    # well.
    scale = np.full(count, 1e-300)
    for both in path_derivatives(spline, pieces, local)[:smoothness]:
        before, after = both[:count], both[count:]
        scale = np.maximum(scale, np.maximum(norms(before), norms(after)))
        jumps |= norms(after - before) > _MIN_JUMP * scale
    return jumps


def evaluate_polynomials(
    coefficients: Float64[np.ndarray, "n k nv"], local: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, "n nv"]:
    """Return each row's polynomial at its own argument, by Horner's rule."""
    total = np.array(coefficients[:, -1])
    for k in range(coefficients.shape[1] - 2, -1, -1):
        total = total * local[:, None] + coefficients[:, k]
    return total
