"""Smoothing: a smooth B-spline curve near a finely sampled path.

Rounded one by one, the corners of a finely sampled curve are so short that jerk allows only little
speed at them, the less the finer the sampling. The curve here is a cubic B-spline by chord length
(continuous second derivative), with the fewest control points that stay near enough, by least
squares; or the spline through all waypoints. Its deviation is bounded: between knots and waypoints
the difference from the path is a cubic, and lies in the convex hull of its Bernstein coefficients.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from planning.domain.curves.cubic import cubic_through
from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.robot.joints import Joint
from planning.domain.robot.manifold import Manifold
from planning.domain.robot.steering import steering_of
from planning.retime.cells import cut_at, with_cuts
from planning.retime.collinear_runs import STRAIGHT, without_straight_runs
from planning.retime.polynomials import halved, norms, to_bernstein

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Numbers of control points to try, fewest first.
_COUNTS = (6, 8, 11, 16, 23, 32, 45, 64, 90)
# Largest number of waypoints for an interpolating spline.
_MOST_THROUGH = 100
_FEWEST = 4
# Weight of points between waypoints relative to waypoints: the path cuts corners of the curve
# there.
_BETWEEN = 0.03
_DEGREE = 3


def smoothed(path: JointPath, deviations: Sequence[float]) -> list[tuple[float, JointSpline]]:
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
    places, points = _line(path, manifold)
    found: list[tuple[float, JointSpline]] = []
    allowed = list(deviations)
    for curve in _nearer_and_nearer(joints, places, points) if len(points) >= _FEWEST else ():
        away = _distance(curve, places, points)
        if allowed and away <= allowed[0]:
            found.append((away, curve))
            allowed = [deviation for deviation in allowed if deviation < away]
        if not allowed:
            break
    return found


def _line(path: JointPath, manifold: Manifold) -> tuple[Array, Array]:
    """Return waypoints without collinear runs or whole turns, and their parameters in [0, 1]."""
    waypoints = without_straight_runs(path.waypoints, manifold, STRAIGHT)
    steps = manifold.minus(waypoints[1:], waypoints[:-1])
    steps = steps[np.sqrt((steps**2).sum(axis=1)) > STRAIGHT]
    moved = np.concatenate([np.zeros((1, path.waypoints.shape[1])), np.cumsum(steps, axis=0)])
    places = np.append(0.0, np.cumsum(np.sqrt((steps**2).sum(axis=1))))
    return places / max(places[-1], STRAIGHT), waypoints[0] + moved


def _nearer_and_nearer(
    joints: tuple[Joint, ...], places: Array, points: Array
) -> Iterator[JointSpline]:
    for count in _COUNTS:
        if count + 2 <= len(points):
            yield _fitted(joints, places, points, count)
    if len(points) <= _MOST_THROUGH:
        yield cubic_through(joints, places, points)


def _fitted(joints: tuple[Joint, ...], places: Array, points: Array, count: int) -> JointSpline:
    """Return the least-squares B-spline with `count` control points, through both end points."""
    between = np.linspace(0.0, 1.0, 4 * count)[1:-1]
    straight = np.stack([np.interp(between, places, column) for column in points.T], axis=1)
    at = np.concatenate([places[1:-1], between])
    weight = np.repeat([1.0, _BETWEEN], [len(places) - 2, len(between)])[:, None]
    matrix = _basis(count, at)
    ends = matrix[:, :1] * points[0] + matrix[:, -1:] * points[-1]
    wanted = np.concatenate([points[1:-1], straight]) - ends
    weighted = (weight**2 * matrix[:, 1:-1]).T
    inner = np.linalg.solve(weighted @ matrix[:, 1:-1], weighted @ wanted)
    controls = np.concatenate([points[:1], inner, points[-1:]])
    edges = np.linspace(0.0, 1.0, count - _DEGREE + 1)
    inside = np.linspace(0.0, 1.0, _DEGREE + 1)
    local = inside * edges[1]
    values = _basis(count, (edges[:-1, None] + local).ravel()) @ controls
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


def _basis(count: int, s: Array) -> Array:
    """Return the clamped uniform cubic B-splines at s, shape (m, count)."""
    inner = np.linspace(0.0, 1.0, count - _DEGREE + 1)
    knots = np.concatenate([np.zeros(_DEGREE), inner, np.ones(_DEGREE)])
    return BSpline.design_matrix(s, knots, _DEGREE).toarray()


def _distance(curve: JointSpline, places: Array, points: Array) -> float:
    """Return a bound on the distance of a curve from the polyline with the same parameter."""
    edges = with_cuts(curve.breaks, [places])
    cut = cut_at(curve, edges)
    line = np.clip(np.searchsorted(places, (edges[:-1] + edges[1:]) / 2) - 1, 0, len(places) - 2)
    slopes = np.diff(points, axis=0) / np.diff(places)[:, None]
    away = np.array(cut.coefficients)
    begin = points[line] + slopes[line] * (edges[:-1] - places[line])[:, None]
    away[:, 0] += cut.bases - begin
    away[:, 1] -= slopes[line]
    return float(norms(halved(to_bernstein(away, np.diff(edges)))).max())
