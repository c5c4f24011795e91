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
from planning.kernel.native import native
from planning.retime.collinear_runs import COLLINEAR_TOLERANCE, without_collinear_waypoints

# 1 / w, and the degree of delta, by smoothness.
_DEVIATION_FACTORS = {1: 4.0, 2: 16 / 3}
_DEGREES = {1: 2, 2: 4}
# Corners sharper than this (cosine of the turn) are kept, with a rest: rounded, they would be
# cusps.
_MIN_CORNER_COSINE = -0.98
# Turns smaller than this (|u2 - u1|) are left to the retimer, which treats them as straight.
_MIN_TURN = 1e-9
_MIN_LENGTH = 1e-9
# Waypoints within this distance of the one before, or this share of the deviation, are merged:
# corners so close together would be too short for the retimer's tolerances.
_MERGE_DISTANCE, _MERGE_RATIO = 1e-6, 1e-3


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
    merge_distance = max(_MIN_LENGTH, min(_MERGE_DISTANCE, _MERGE_RATIO * deviation))
    waypoints = without_collinear_waypoints(path.waypoints, manifold, COLLINEAR_TOLERANCE)
    if deviation > 0:
        waypoints = _without_duplicates(waypoints, manifold, merge_distance)
    if deviation <= 0 or len(waypoints) < 3:
        return JointSpline.through(path.group.joints, waypoints)
    module = native()
    if module is not None and manifold.is_vector_space:
        arrays = module.blend(waypoints, deviation, smoothness == 2)
        return JointSpline(path.group.joints, *arrays)
    return blended_in_numpy(path, waypoints, deviation, smoothness)


def blended_in_numpy(
    path: JointPath, waypoints: Array, deviation: float, smoothness: int
) -> JointSpline:
    """Return the same without the kernel, which has the same sums, on any manifold.

    Args:
        path: The path.
        waypoints: Those of its waypoints that are corners or ends, at least three, shape (n, nq).
        deviation: As for `blend_corners`, positive.
        smoothness: As for `blend_corners`.
    """
    manifold = Manifold.of(path.group.joints)
    steps = manifold.minus(waypoints[1:], waypoints[:-1])
    lengths = np.sqrt((steps**2).sum(axis=1))
    # Directions of lines at their first waypoint, and at their second.
    start_directions = steps / lengths[:, None]
    end_directions = -manifold.minus(waypoints[:-1], waypoints[1:]) / lengths[:, None]
    blend_lengths = _blend_lengths(
        start_directions, end_directions, lengths, deviation * _DEVIATION_FACTORS[smoothness]
    )
    # Every line but the last is followed by the corner at its end.
    widths = np.stack(
        [lengths - blend_lengths[:-1] - blend_lengths[1:], 2 * blend_lengths[1:]], axis=1
    )
    polynomials = np.zeros((len(lengths), 2, _DEGREES[smoothness] + 1, start_directions.shape[1]))
    polynomials[:, 0, 0] = blend_lengths[:-1, None] * start_directions
    polynomials[:, 0, 1] = start_directions
    polynomials[:-1, 1] = _corner_polynomials(
        blend_lengths[1:-1, None], end_directions[:-1], start_directions[1:], smoothness
    )
    is_nonempty = widths > [_MIN_LENGTH, 0.0]
    bases = np.stack([waypoints[:-1], waypoints[1:]], axis=1)
    return _spline(path, widths[is_nonempty], bases[is_nonempty], polynomials[is_nonempty])


def _blend_lengths(
    start_directions: Array, end_directions: Array, lengths: Array, max_offset: float
) -> Array:
    """Return lambda at every waypoint; 0 at both ends and at corners that are not rounded.

    Args:
        start_directions: Unit directions of the lines where they begin.
        end_directions: Unit directions of the lines where they end.
        lengths: Lengths of the lines.
        max_offset: Largest value of lambda |u2 - u1|.
    """
    before, after = end_directions[:-1], start_directions[1:]
    turns = np.sqrt(((after - before) ** 2).sum(axis=1))
    is_rounded = (turns > _MIN_TURN) & ((before * after).sum(axis=1) > _MIN_CORNER_COSINE)
    max_lengths = np.minimum(lengths[:-1], lengths[1:]) / 2
    blend_lengths = np.minimum(max_offset / np.maximum(turns, _MIN_TURN), max_lengths)
    return np.concatenate([[0.0], np.where(is_rounded, blend_lengths, 0.0), [0.0]])


def _corner_polynomials(blend_length: Array, u1: Array, u2: Array, smoothness: int) -> Array:
    """Return power-basis coefficients of rounded corners for x in [0, 2 lambda], corners first."""
    width = np.where(blend_length > 0, 2 * blend_length, 1.0)
    turn = u2 - u1
    if smoothness == 1:
        return np.stack([-blend_length * u1, u1, turn / (2 * width)], axis=1)
    zero = np.zeros_like(u1)
    ends = turn / (width * width), -turn / (2 * (width * width * width))
    return np.stack([-blend_length * u1, u1, zero, *ends], axis=1)


def _spline(path: JointPath, widths: Array, bases: Array, polynomials: Array) -> JointSpline:
    """Return the pieces as one spline over [0, 1]."""
    total = float(widths.sum())
    breaks = np.concatenate([[0.0], np.cumsum(widths) / total])
    breaks[-1] = 1.0
    powers = np.vander([total], polynomials.shape[1], increasing=True)[0]
    return JointSpline(path.group.joints, breaks, bases, polynomials * powers[:, None])


def _without_duplicates(waypoints: Array, manifold: Manifold, merge_distance: float) -> Array:
    """Return the waypoints without repetitions of the one before; both ends are kept."""
    if (manifold.distance(waypoints[1:], waypoints[:-1]) > merge_distance).all():
        return waypoints
    kept = [0]
    for i in range(1, len(waypoints)):
        if float(manifold.distance(waypoints[i], waypoints[kept[-1]])) > merge_distance:
            kept.append(i)
    if len(kept) == 1 or kept[-1] != len(waypoints) - 1:
        kept = [*kept[: max(1, len(kept) - 1)], len(waypoints) - 1]
    return waypoints[kept]
