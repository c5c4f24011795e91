"""Shapes: the curves that one path can become before it is timed."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.steering import steering_of
from planning.retime.blend import blend_corners
from planning.retime.bspline_smoothing import smooth_path
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import CollisionChecker

# How far corners may be rounded, largest first (joint-space length). The last resort, 0, follows
# the very path that was checked and rests at every corner.
_DEVIATIONS = (0.1, 0.03, 0.008, 0.0)
# How closely a curve is looked at before it is timed (joint-space length).
_COARSE_SPACING = 0.03


@dataclass(frozen=True)
class PathCurve:
    """A curve near a path.

    Attributes:
        name: What was done to the path.
        deviation: How far the curve may be from the path (joint-space length).
        spline: The curve.
    """

    name: str
    deviation: float
    spline: JointSpline


def collision_free_curves(
    path: JointPath,
    options: RetimeOptions,
    checker: CollisionChecker,
    constraints: PathConstraints | None,
) -> Iterator[PathCurve]:
    """Yield the shapes that do not collide at a glance; what does is not worth timing.

    The path itself is the last one, whatever it looks like.
    """
    count = int(path.length / _COARSE_SPACING) + 2
    curve, is_yielded = None, True
    for curve in _curves(path, options):
        samples = curve.spline.positions(np.linspace(0.0, 1.0, count))
        is_yielded = curve.deviation == 0 or (
            (constraints is None or bool(constraints.are_satisfied(samples).all()))
            and bool(checker.are_free(samples).all())
        )
        if is_yielded:
            yield curve
    # Without corners to round the last is the path itself under another name.
    if curve is not None and not is_yielded:
        yield PathCurve("path itself", 0.0, curve.spline)


def _curves(path: JointPath, options: RetimeOptions) -> Iterator[PathCurve]:
    """Yield the farthest from the path first; jerk limits want curves that are smooth all along."""
    smoothness = 2 if options.method == "ruckig" else 1
    max_deviations = _max_deviations(options)
    if options.method == "ruckig":
        for max_deviation, curve in smooth_path(path, max_deviations[:-1]):
            yield PathCurve(f"path smoothed within {max_deviation:.3g}", max_deviation, curve)
    # Rounded, a car's path would leave the arcs that it can drive.
    deviations = max_deviations[-1:] if steering_of(path.group) else max_deviations
    previous: JointSpline | None = None
    for deviation in deviations:
        spline = blend_corners(path, deviation, smoothness)
        if spline != previous:
            name = f"path with corners rounded by {deviation:g}" if deviation else "path itself"
            yield PathCurve(name, deviation, spline)
        previous = spline


def _max_deviations(options: RetimeOptions) -> tuple[float, ...]:
    """Return how far a curve may be from the path, largest first; the last is 0."""
    largest = options.deviation
    if largest is None:
        return _DEVIATIONS
    return largest, *(smaller for smaller in _DEVIATIONS if smaller < largest)
