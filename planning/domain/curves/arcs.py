"""Arcs: constant-velocity motions of a steered base between waypoints, as quintic polynomials.

A base at the constant velocity (v_x, v_y, omega) of its own frame has yaw = yaw_0 + omega s, which
is a polynomial, and x and y, which are not. They become polynomials of degree five that meet
position, first and second derivative at both ends of short pieces (Hermite's interpolation): on a
piece that turns by h their error in position is at most h^6 / 46,080, in direction some h^5 / 10^4
and in curvature some h^4 / 10^3 of the exact values. With h = 0.2 that is 1.4e-9 of the radius
and 3e-8 rad. The derivatives agree where two pieces of an arc meet, so it needs no stop there.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.robot.steering import SteeredManifold

# Largest turn of a piece [rad], and smallest number of pieces of an arc: retimers cut paths at
# pieces, and a long gentle arc on one piece alone leaves no room to reach full speed.
_MAX_PIECE_ANGLE, _MIN_NUM_PIECES = 0.2, 4
# An arc that turns less is a line [rad]: the arc is less than a millionth of a nanometre off.
_MIN_ARC_ANGLE = 1e-12
_MIN_LENGTH = 1e-12


def arcs_through(manifold: SteeredManifold, waypoints: Float64[np.ndarray, "n nq"]) -> JointSpline:
    """Return the arcs and lines between waypoints, parametrised by their joint-space length."""
    deltas = manifold.minus(waypoints[1:], waypoints[:-1])
    lengths = np.sqrt((deltas**2).sum(axis=1))
    keep = lengths > _MIN_LENGTH
    if not keep.any():
        return JointSpline.through(manifold.joints, waypoints)
    deltas, origins = deltas[keep], waypoints[:-1][keep]
    angles = np.abs(deltas[:, [iv + 2 for _, iv in manifold.offsets]]).max(axis=1)
    min_counts = np.where(angles < _MIN_ARC_ANGLE, 1, _MIN_NUM_PIECES)
    counts = np.maximum(min_counts, np.ceil(angles / _MAX_PIECE_ANGLE - 1e-9)).astype(int)
    rows = np.repeat(np.arange(len(counts)), counts)
    steps = deltas[rows] / counts[rows][:, None]
    step_indices = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
    begins = manifold.plus(origins[rows], step_indices[:, None] * steps)
    total = lengths[keep].sum()
    widths = np.linalg.norm(steps, axis=1) / total
    breaks = np.concatenate([[0.0], np.cumsum(widths)])
    breaks[-1] = 1.0
    coefficients = _polynomials(manifold, begins, steps)
    powers = np.diff(breaks)[:, None, None] ** -np.arange(6.0)[None, :, None]
    return JointSpline(manifold.joints, breaks, begins, coefficients * powers)


def _polynomials(manifold: SteeredManifold, begins: Array, steps: Array) -> Array:
    """Return coefficients in u in [0, 1] of each piece, lowest first, shape (n, 6, nv)."""
    coefficients = np.zeros((len(steps), 6, steps.shape[1]))
    coefficients[:, 1] = steps
    ends = manifold.plus(begins, steps)
    for iq, iv in manifold.offsets:
        angle = steps[:, iv + 2]
        first = [_rates(q[:, iq + 2], steps[:, iv : iv + 2], angle) for q in (begins, ends)]
        displacement = ends[:, iq : iq + 2] - begins[:, iq : iq + 2]
        arc = _hermite(displacement, *first[0], *first[1])
        line = np.zeros_like(arc)
        line[:, 1] = displacement
        is_line = np.abs(angle) < _MIN_ARC_ANGLE
        coefficients[:, :, iv : iv + 2] = np.where(is_line[:, None, None], line, arc)
    return coefficients


def _rates(yaw: Array, velocity: Array, angle: Array) -> tuple[Array, Array]:
    """Return the first and second derivative of x and y at a yaw, each shape (n, 2)."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = velocity.T
    rate = np.stack([c * x - s * y, s * x + c * y], axis=1)
    return rate, angle[:, None] * np.stack([-rate[:, 1], rate[:, 0]], axis=1)


def _hermite(displacement: Array, v0: Array, a0: Array, v1: Array, a1: Array) -> Array:
    """Return polynomials on [0, 1] from 0 to `displacement` with given derivatives at both ends."""
    # Residuals at the end of each piece of the polynomial that meets the start's values alone.
    p, v, a = displacement - v0 - a0 / 2, v1 - v0 - a0, a1 - a0
    high_coefficients = (10 * p - 4 * v + a / 2, -15 * p + 7 * v - a, 6 * p - 3 * v + a / 2)
    return np.stack([np.zeros_like(displacement), v0, a0 / 2, *high_coefficients], axis=1)
