"""Corner blending: rounded corners of a path, so that a motion need not rest at them.

At corner q_c with unit directions u1 (in) and u2 (out), the curve leaves the incoming line at
-lambda u1 and joins the outgoing one at +lambda u2, both in the tangent space at q_c, where lines
through q_c are straight on any manifold. With x in [0, 2 lambda] and y = x / (2 lambda),

    delta'(x) = u1 + (u2 - u1) f(y),  f(y) = y (smoothness 1) or 3 y^2 - 2 y^3 (smoothness 2),

so the speed in x is 1 on the lines and at the joins, and r'' is constant, or zero at the joins. The
point of the curve nearest to the corner is its middle, delta(lambda) = (u2 - u1) lambda w with w =
1/4 or 3/16, which bounds how far it is from the path.
"""

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.robot.manifold import Manifold
from planning.domain.robot.steering import steering_of
from planning.retime.collinear_runs import STRAIGHT, without_straight_runs

# 1 / w, and the degree of delta, by smoothness.
_FARTHEST = {1: 4.0, 2: 16 / 3}
_DEGREE = {1: 2, 2: 4}
# Corners sharper than this (cosine of the turn) are kept, with a rest: rounded, they would be
# cusps.
_SHARPEST = -0.98
# Turns smaller than this (|u2 - u1|) are left to the retimer, which treats them as straight.
_STRAIGHT = 1e-9
_SHORTEST = 1e-9
# Waypoints within this distance of the one before, or this share of the deviation, are merged:
# corners so close together would be too short for the retimer's tolerances.
_ALIKE, _ALIKE_SHARE = 1e-6, 1e-3


def blend_corners(path: JointPath, deviation: float, smoothness: int = 1) -> JointSpline:
    """Return the path with rounded corners; almost equal consecutive waypoints are merged.

    Waypoints in the middle of straight lines change nothing.

    Args:
        path: Waypoints joined by geodesics; a path with a steered base is not rounded.
        deviation: Largest distance of the curve from each corner (joint-space length); 0 for no
            blending.
        smoothness: 1 for a continuous r', 2 for a continuous r'' as well.
    """
    if steering_of(path.group):
        return path.spline
    manifold = Manifold.of(path.group.joints)
    alike = max(_SHORTEST, min(_ALIKE, _ALIKE_SHARE * deviation))
    waypoints = without_straight_runs(path.waypoints, manifold, STRAIGHT)
    if deviation > 0:
        waypoints = _distinct(waypoints, manifold, alike)
    if deviation <= 0 or len(waypoints) < 3:
        return JointSpline.through(path.group.joints, waypoints)
    steps = manifold.minus(waypoints[1:], waypoints[:-1])
    lengths = np.sqrt((steps**2).sum(axis=1))
    # Directions of lines at their first waypoint, and at their second.
    leaving = steps / lengths[:, None]
    arriving = -manifold.minus(waypoints[:-1], waypoints[1:]) / lengths[:, None]
    reaches = _reaches(leaving, arriving, lengths, deviation * _FARTHEST[smoothness])
    # Every line but the last is followed by the corner at its end.
    widths = np.stack([lengths - reaches[:-1] - reaches[1:], 2 * reaches[1:]], axis=1)
    polynomials = np.zeros((len(lengths), 2, _DEGREE[smoothness] + 1, leaving.shape[1]))
    polynomials[:, 0, 0] = reaches[:-1, None] * leaving
    polynomials[:, 0, 1] = leaving
    polynomials[:-1, 1] = _arcs(reaches[1:-1, None], arriving[:-1], leaving[1:], smoothness)
    is_there = widths > [_SHORTEST, 0.0]
    bases = np.stack([waypoints[:-1], waypoints[1:]], axis=1)
    return _spline(path, widths[is_there], bases[is_there], polynomials[is_there])


def _reaches(leaving: Array, arriving: Array, lengths: Array, farthest: float) -> Array:
    """Return lambda at every waypoint; 0 at both ends and at corners that are not rounded.

    Args:
        leaving: Unit directions of the lines where they begin.
        arriving: Unit directions of the lines where they end.
        lengths: Lengths of the lines.
        farthest: Largest value of lambda |u2 - u1|.
    """
    before, after = arriving[:-1], leaving[1:]
    turns = np.sqrt(((after - before) ** 2).sum(axis=1))
    is_rounded = (turns > _STRAIGHT) & ((before * after).sum(axis=1) > _SHARPEST)
    room = np.minimum(lengths[:-1], lengths[1:]) / 2
    wanted = np.minimum(farthest / np.maximum(turns, _STRAIGHT), room)
    return np.concatenate([[0.0], np.where(is_rounded, wanted, 0.0), [0.0]])


def _arcs(reach: Array, u1: Array, u2: Array, smoothness: int) -> Array:
    """Return power-basis coefficients of rounded corners, x in [0, 2 reach], corners first."""
    width = np.where(reach > 0, 2 * reach, 1.0)
    turn = u2 - u1
    if smoothness == 1:
        return np.stack([-reach * u1, u1, turn / (2 * width)], axis=1)
    zero = np.zeros_like(u1)
    ends = turn / width**2, -turn / (2 * width**3)
    return np.stack([-reach * u1, u1, zero, *ends], axis=1)


def _spline(path: JointPath, widths: Array, bases: Array, polynomials: Array) -> JointSpline:
    """Return the pieces as one spline over [0, 1]."""
    total = float(widths.sum())
    breaks = np.concatenate([[0.0], np.cumsum(widths) / total])
    breaks[-1] = 1.0
    powers = total ** np.arange(polynomials.shape[1])
    return JointSpline(path.group.joints, breaks, bases, polynomials * powers[:, None])


def _distinct(waypoints: Array, manifold: Manifold, alike: float) -> Array:
    """Return the waypoints without repetitions of the one before; both ends are kept."""
    if (manifold.distance(waypoints[1:], waypoints[:-1]) > alike).all():
        return waypoints
    keep = [0]
    for i in range(1, len(waypoints)):
        if float(manifold.distance(waypoints[i], waypoints[keep[-1]])) > alike:
            keep.append(i)
    if len(keep) == 1 or keep[-1] != len(waypoints) - 1:
        keep = [*keep[: max(1, len(keep) - 1)], len(waypoints) - 1]
    return waypoints[keep]
