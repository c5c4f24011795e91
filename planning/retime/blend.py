"""Round the corners of a path, so that it can be followed without resting.

At corner q_c with unit directions u1 (in) and u2 (out), the curve leaves the incoming line at
-lambda u1 and joins the outgoing one at +lambda u2, both in the tangent space at q_c, where lines
through q_c are straight on any manifold. With x in [0, 2 lambda] and y = x / (2 lambda),

    delta'(x) = u1 + (u2 - u1) f(y),  f(y) = y (smoothness 1) or 3 y^2 - 2 y^3 (smoothness 2),

so the speed in x is 1 on the lines and at the joins, and r'' is constant, or zero at the joins. The
curve's nearest point to the corner is its middle, delta(lambda) = (u2 - u1) lambda w with
w = 1/4 or 3/16, which bounds how far it is from the path.
"""

from typing import Any

import numpy as np

from planning.domain.curve import JointSpline
from planning.domain.manifold import Manifold
from planning.domain.path import JointPath

type Array = np.ndarray[Any, np.dtype[np.float64]]

_MIDDLE = {1: 1 / 4, 2: 3 / 16}
# Corners sharper than this (cosine of the turn) are rested at: rounded, they would be cusps.
_SHARPEST = -0.98
# Turns smaller than this are left to the retimer, which passes them as straight (|u2 - u1|).
_STRAIGHT = 1e-9
_SHORTEST = 1e-9


def blend_corners(path: JointPath, deviation: float, smoothness: int = 1) -> JointSpline:
    """Return the path with its corners rounded.

    Args:
        path: Waypoints joined by geodesics.
        deviation: How far the curve may be from each corner (joint-space length); 0 for none.
        smoothness: 1 for a continuous r', 2 for a continuous r'' as well.
    """
    manifold = Manifold(path.group.joints)
    waypoints = _distinct(path.waypoints, manifold)
    if deviation <= 0 or len(waypoints) < 3:
        return path.spline
    steps = manifold.minus(waypoints[1:], waypoints[:-1])
    lengths = np.linalg.norm(steps, axis=1)
    units = steps / lengths[:, None]
    reaches = _reaches(waypoints, units, lengths, deviation, _MIDDLE[smoothness], manifold)
    pieces: list[tuple[float, Array, Array]] = []
    for i in range(len(steps)):
        before, after = reaches[i], reaches[i + 1]
        straight = lengths[i] - before - after
        if straight > _SHORTEST:
            line = np.stack([before * units[i], units[i]])
            pieces.append((straight, waypoints[i], line))
        if after > 0:
            back = -manifold.minus(waypoints[i : i + 1], waypoints[i + 1 : i + 2])[0] / lengths[i]
            arc = _arc(after, back, units[i + 1], smoothness)
            pieces.append((2 * after, waypoints[i + 1], arc))
    return _assemble(path, pieces)


def _reaches(
    waypoints: Array,
    units: Array,
    lengths: Array,
    deviation: float,
    middle: float,
    manifold: Manifold,
) -> Array:
    """Return lambda at every waypoint; 0 at both ends and where nothing is rounded."""
    reaches = np.zeros(len(waypoints))
    for i in range(1, len(waypoints) - 1):
        back = -manifold.minus(waypoints[i - 1], waypoints[i]) / lengths[i - 1]
        turn = float(np.linalg.norm(units[i] - back))
        if turn > _STRAIGHT and float(back @ units[i]) > _SHARPEST:
            room = min(lengths[i - 1], lengths[i]) / 2
            reaches[i] = min(deviation / (middle * turn), room)
    return reaches


def _arc(reach: float, u1: Array, u2: Array, smoothness: int) -> Array:
    """Return power-basis coefficients of the rounded corner, in x in [0, 2 reach]."""
    width = 2 * reach
    turn = u2 - u1
    if smoothness == 1:
        return np.stack([-reach * u1, u1, turn / (2 * width)])
    zero = np.zeros_like(u1)
    return np.stack([-reach * u1, u1, zero, turn / width**2, -turn / (2 * width**3)])


def _assemble(path: JointPath, pieces: list[tuple[float, Array, Array]]) -> JointSpline:
    """Return the pieces as one spline over [0, 1]."""
    widths = np.array([width for width, _, _ in pieces])
    total = float(widths.sum())
    breaks = np.concatenate([[0.0], np.cumsum(widths) / total])
    breaks[-1] = 1.0
    degree = max(len(coefficients) for _, _, coefficients in pieces)
    scaled = np.zeros((len(pieces), degree, pieces[0][2].shape[1]))
    for i, (_, _, coefficients) in enumerate(pieces):
        powers = total ** np.arange(len(coefficients))
        scaled[i, : len(coefficients)] = coefficients * powers[:, None]
    bases = np.stack([base for _, base, _ in pieces])
    return JointSpline(path.group.joints, breaks, bases, scaled)


def _distinct(waypoints: Array, manifold: Manifold) -> Array:
    """Return the waypoints without those that repeat the one before; both ends are kept."""
    keep = [0]
    for i in range(1, len(waypoints)):
        if float(manifold.distance(waypoints[i], waypoints[keep[-1]])) > _SHORTEST:
            keep.append(i)
    if len(keep) == 1 or keep[-1] != len(waypoints) - 1:
        keep = [*keep[: max(1, len(keep) - 1)], len(waypoints) - 1]
    return waypoints[keep]
