"""Shapes: the curves that one path can become before it is timed."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.steering import steering_of
from planning.retime.blend import blend_corners
from planning.retime.smooth import smoothed
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import CollisionJudge

# How far corners may be rounded, largest first (joint-space length). The last resort, 0, follows
# the very path that was checked and rests at every corner.
_DEVIATIONS = (0.1, 0.03, 0.008, 0.0)
# How closely a curve is looked at before it is timed (joint-space length).
_GLANCE = 0.03


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
    judge: CollisionJudge,
    rules: PathConstraints | None,
) -> Iterator[PathCurve]:
    """Yield the shapes that do not collide at a glance; what does is not worth timing.

    The path itself is the last one, whatever it looks like.
    """
    count = int(path.length / _GLANCE) + 2
    shape, is_told = None, True
    for shape in _shapes(path, options):
        glances = shape.spline.positions(np.linspace(0.0, 1.0, count))
        is_told = shape.deviation == 0 or (
            (rules is None or bool(rules.are_kept(glances).all()))
            and bool(judge.are_free(glances).all())
        )
        if is_told:
            yield shape
    # Without corners to round the last is the path itself under another name.
    if shape is not None and not is_told:
        yield PathCurve("path itself", 0.0, shape.spline)


def _shapes(path: JointPath, options: RetimeOptions) -> Iterator[PathCurve]:
    """Yield the farthest from the path first; jerk limits want curves that are smooth all along."""
    smoothness = 2 if options.method == "ruckig" else 1
    allowed = _deviations(options)
    if options.method == "ruckig":
        for away, curve in smoothed(path, allowed[:-1]):
            yield PathCurve(f"path smoothed within {away:.3g}", away, curve)
    # Rounded, a car's path would leave the arcs that it can drive.
    deviations = allowed[-1:] if steering_of(path.group) else allowed
    before: JointSpline | None = None
    for deviation in deviations:
        spline = blend_corners(path, deviation, smoothness)
        if spline != before:
            name = f"path with corners rounded by {deviation:g}" if deviation else "path itself"
            yield PathCurve(name, deviation, spline)
        before = spline


def _deviations(options: RetimeOptions) -> tuple[float, ...]:
    """Return how far a curve may be from the path, largest first; the last is 0."""
    most = options.deviation
    if most is None:
        return _DEVIATIONS
    return most, *(less for less in _DEVIATIONS if less < most)
