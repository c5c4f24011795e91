"""Smoothing: a smooth B-spline curve near a finely sampled path.

Rounded one by one, the corners of a finely sampled curve are so short that jerk allows only little
speed at them, the less the finer the sampling. The curve here is a cubic B-spline by chord length
(continuous second derivative), with the fewest control points that stay near enough, by least
squares; or the spline through all waypoints. Its deviation is bounded: between knots and waypoints
the difference from the path is a cubic, and lies in the convex hull of its Bernstein coefficients.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.cubic import cubic_through
from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.robot.joints import Joint
from planning.domain.robot.manifold import Manifold
from planning.domain.robot.steering import steering_of
from planning.retime.cells import cut_at, with_extra_edges
from planning.retime.collinear_runs import COLLINEAR_TOLERANCE, without_collinear_waypoints
from planning.retime.polynomials import halved, norms, to_bernstein

# Numbers of control points to try, fewest first.
_CONTROL_POINT_COUNTS = (6, 8, 11, 16, 23, 32, 45, 64, 90)
# Largest number of waypoints for an interpolating spline.
_MAX_INTERPOLATED_WAYPOINTS = 100
_MIN_WAYPOINTS = 4
# Weight of points between waypoints relative to waypoints: the path cuts corners of the curve
# there.
_MIDPOINT_WEIGHT = 0.03
_DEGREE = 3


def smooth_path(path: JointPath, deviations: Sequence[float]) -> list[tuple[float, JointSpline]]:
    """Return curves with continuous second derivative near a path, with bounds on their deviation.

    With a floating joint or a steered base there are none; there are fewer curves than deviations
    where one curve satisfies several, or none is near enough.

    Args:
        path: Waypoints joined by geodesics.
        deviations: Largest distances of curves from the path, decreasing (joint-space length).
    """
    joints, manifold = path.group.joints, Manifold(path.group.joints)
    if steering_of(path.group) or not manifold.is_flat:
        return []
    parameters, points = _polyline(path, manifold)
    curves: list[tuple[float, JointSpline]] = []
    remaining = list(deviations)
    if len(points) < _MIN_WAYPOINTS:
        return curves
    for curve in _candidate_curves(joints, parameters, points):
        deviation_bound = _deviation_bound(curve, parameters, points)
        if remaining and deviation_bound <= remaining[0]:
            curves.append((deviation_bound, curve))
            remaining = [deviation for deviation in remaining if deviation < deviation_bound]
        if not remaining:
            break
    return curves


def _polyline(path: JointPath, manifold: Manifold) -> tuple[Array, Array]:
    """Return waypoints without collinear runs or whole turns, and their parameters in [0, 1]."""
    waypoints = without_collinear_waypoints(path.waypoints, manifold, COLLINEAR_TOLERANCE)
    steps = manifold.minus(waypoints[1:], waypoints[:-1])
    steps = steps[np.sqrt((steps**2).sum(axis=1)) > COLLINEAR_TOLERANCE]
    displacements = np.concatenate([
        np.zeros((1, path.waypoints.shape[1])),
        np.cumsum(steps, axis=0),
    ])
    parameters = np.append(0.0, np.cumsum(np.sqrt((steps**2).sum(axis=1))))
    return parameters / max(parameters[-1], COLLINEAR_TOLERANCE), waypoints[0] + displacements


def _candidate_curves(
    joints: tuple[Joint, ...], parameters: Array, points: Array
) -> Iterator[JointSpline]:
    for num_control_points in _CONTROL_POINT_COUNTS:
        if num_control_points + 2 <= len(points):
            yield _fit_bspline(joints, parameters, points, num_control_points)
    if len(points) <= _MAX_INTERPOLATED_WAYPOINTS:
        yield cubic_through(joints, parameters, points)


def _fit_bspline(
    joints: tuple[Joint, ...], parameters: Array, points: Array, num_control_points: int
) -> JointSpline:
    """Return the least-squares B-spline of `num_control_points`, through both end points."""
    between = np.linspace(0.0, 1.0, 4 * num_control_points)[1:-1]
    polyline_points = np.stack(
        [np.interp(between, parameters, column) for column in points.T], axis=1
    )
    sample_parameters = np.concatenate([parameters[1:-1], between])
    weights = np.repeat([1.0, _MIDPOINT_WEIGHT], [len(parameters) - 2, len(between)])[:, None]
    matrix = _bspline_basis(num_control_points, sample_parameters)
    ends = matrix[:, :1] * points[0] + matrix[:, -1:] * points[-1]
    targets = np.concatenate([points[1:-1], polyline_points]) - ends
    weighted = (weights**2 * matrix[:, 1:-1]).T
    inner = np.linalg.solve(weighted @ matrix[:, 1:-1], weighted @ targets)
    control_points = np.concatenate([points[:1], inner, points[-1:]])
    edges = np.linspace(0.0, 1.0, num_control_points - _DEGREE + 1)
    inside = np.linspace(0.0, 1.0, _DEGREE + 1)
    local = inside * edges[1]
    values = _bspline_basis(num_control_points, (edges[:-1, None] + local).ravel()) @ control_points
    # Four values between two knots determine the cubic.
    pieces = values.reshape(len(edges) - 1, _DEGREE + 1, -1)
    pieces[1:, 0] = pieces[:-1, -1]
    pieces[0, 0], pieces[-1, -1] = points[0], points[-1]
    bases = np.array(pieces[:, 0])
    unit = np.linalg.inv(inside[:, None] ** np.arange(_DEGREE + 1))
    powers = edges[1] ** -np.arange(_DEGREE + 1, dtype=np.float64)
    coefficients = (unit @ (pieces - bases[:, None])) * powers[:, None]
    coefficients[:, 0] = 0.0
    return JointSpline(joints, edges, bases, coefficients)


def _bspline_basis(num_control_points: int, s: Array) -> Array:
    """Return the clamped uniform cubic B-splines at s, shape (m, num_control_points).

    By the recursion of Cox and de Boor: scipy has it, and takes 0.4 s to import for it.
    """
    num_spans = num_control_points - _DEGREE
    inner_knots = np.linspace(0.0, 1.0, num_spans + 1)
    knots = np.concatenate([np.zeros(_DEGREE), inner_knots, np.ones(_DEGREE)])
    spans = _DEGREE + np.clip((s * num_spans).astype(int), 0, num_spans - 1)
    values = np.zeros((len(s), len(knots) - 1))
    values[np.arange(len(s)), spans] = 1.0
    for degree in range(1, _DEGREE + 1):
        widths = knots[degree:] - knots[:-degree]
        fractions = (s[:, None] - knots[:-degree]) / np.where(widths > 0, widths, 1.0)
        fractions[:, widths <= 0] = 0.0
        rising = fractions[:, : values.shape[1] - 1] * values[:, :-1]
        falling = np.where(widths[1:] > 0, 1 - fractions[:, 1:], 0.0) * values[:, 1:]
        values = rising + falling
    return values


def _deviation_bound(curve: JointSpline, parameters: Array, points: Array) -> float:
    """Return a bound on the distance of a curve from the polyline with the same parameter."""
    edges = with_extra_edges(curve.breaks, [parameters])
    cut = cut_at(curve, edges)
    line = np.clip(
        np.searchsorted(parameters, (edges[:-1] + edges[1:]) / 2) - 1, 0, len(parameters) - 2
    )
    slopes = np.diff(points, axis=0) / np.diff(parameters)[:, None]
    difference = np.array(cut.coefficients)
    begin = points[line] + slopes[line] * (edges[:-1] - parameters[line])[:, None]
    difference[:, 0] += cut.bases - begin
    difference[:, 1] -= slopes[line]
    return float(norms(halved(to_bernstein(difference, np.diff(edges)))).max())
