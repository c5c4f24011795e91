"""Rate bounds of a curve, per block of coordinates with one limit, by Bernstein coefficients."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import Curve, derivative
from planning.domain.robot.joints import JointLimits, JointType
from planning.retime.limits.angular_rate_bounds import (
    has_moving_axis,
    rate_bounds,
    with_derivatives,
)
from planning.retime.polynomials import bisected_form, halved, norms, to_bernstein

_NUM_BISECTIONS = 2


def block_peaks(curve: Curve, limits: JointLimits, order: int) -> Float64[np.ndarray, "n blocks"]:
    """Return an upper bound on the norm of each block's order-th derivative on each piece.

    Not promised: that the bound is attained. It exceeds the peak by some per mille on pieces with
    small curvature.
    """
    widths = np.diff(curve.breaks)
    forms = bisected_form(derivative(curve.coefficients, order), widths, _NUM_BISECTIONS)
    peaks = block_norms(forms, limits).max(axis=1)
    if order > 1:
        for i in floating_rotation_blocks(curve, limits):
            _replace_rotation_bounds(peaks[:, i], curve, list(limits.blocks[i]), order)
    return peaks


def bernstein_block_norms(
    curve: Curve, limits: JointLimits, order: int
) -> Float64[np.ndarray, "n k blocks"]:
    """Return the norms of the Bernstein coefficients of each block's order-th derivative."""
    polynomials = to_bernstein(derivative(curve.coefficients, order), np.diff(curve.breaks))
    return block_norms(polynomials, limits)


def block_norms(vectors: Float64[np.ndarray, "*n nv"], limits: JointLimits) -> Array:
    """Return the norm of every block of vectors, shape (*n, blocks)."""
    if all(len(block) == 1 for block in limits.blocks):
        return np.abs(vectors[..., [block[0] for block in limits.blocks]])
    return np.stack([norms(vectors[..., list(block)]) for block in limits.blocks], axis=-1)


def floating_rotation_blocks(curve: Curve, limits: JointLimits) -> list[int]:
    """Return the indices of the blocks that are rotations of floating joints."""
    starts: list[int] = []
    offset = 0
    for joint in curve.joints:
        if joint.type is JointType.FLOATING:
            starts.append(offset)
        offset += joint.num_velocities
    return [i for i, block in enumerate(limits.blocks) if block[0] in starts and len(block) == 3]


def _replace_rotation_bounds(peaks: Array, curve: Curve, indices: list[int], order: int) -> None:
    """Replace the bounds of pieces with a moving rotation axis by those of angular rates."""
    coefficients = curve.coefficients[:, :, indices]
    moving = np.flatnonzero(has_moving_axis(coefficients))
    if not len(moving):
        return
    widths = np.diff(curve.breaks)[moving]
    polynomials = with_derivatives(coefficients[moving], widths, order)
    for _ in range(_NUM_BISECTIONS):
        polynomials = halved(polynomials)
    parts = 2**_NUM_BISECTIONS
    upper, _ = rate_bounds(polynomials, np.repeat(widths / parts, parts), order)
    peaks[moving] = upper.reshape(-1, parts).max(axis=1)
