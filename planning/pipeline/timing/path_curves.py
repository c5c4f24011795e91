"""PathCurve: smooth curves near one path, to be timed: corners rounded, or smoothed."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.steering import steering_of
from planning.retime.blend import blend_corners
from planning.retime.bspline_smoothing import smooth_path
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import CollisionChecker

# Largest deviations of rounded corners from the path (joint-space length), tried in turn. The last
# one, 0, follows the verified path itself and rests at every corner.
_DEVIATIONS = (0.1, 0.03, 0.008, 0.0)
# Sample spacing of the collision check of a curve before it is timed (joint-space length).
_COARSE_SPACING = 0.03
# Number of samples from one look at the clock to the next.
_NUM_SAMPLES = 2_000


@dataclass(frozen=True)
class PathCurve:
    """Curve near a path.

    Attributes:
        name: Name for messages and reports, which says how the path was changed.
        deviation: Largest distance of the curve from the path (joint-space length).
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
    deadline: Deadline,
) -> Iterator[PathCurve]:
    """Yield the curves that are free and satisfy path constraints at coarse samples.

    The path itself is the last one, without that check.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
    """

    def is_free(curve: PathCurve) -> bool:
        """Return whether the curve may be timed, by samples."""
        for samples in _samples(curve.spline, path.length, deadline):
            if constraints is not None and not constraints.are_satisfied(samples).all():
                return False
            if not checker.are_free(samples).all():
                return False
        return True

    curve, is_yielded = None, True
    for curve in _curves(path, options):
        is_yielded = curve.deviation == 0 or is_free(curve)
        if is_yielded:
            yield curve
    # Without corners to round, the last curve is the path itself under another name.
    if curve is not None and not is_yielded:
        yield PathCurve("path itself", 0.0, curve.spline)


def _samples(spline: JointSpline, length: float, deadline: Deadline) -> Iterator[Array]:
    """Yield samples of a curve near a path of some length, a part of them at a time."""
    parameters = np.linspace(0.0, 1.0, int(length / _COARSE_SPACING) + 2)
    for begin in range(0, len(parameters), _NUM_SAMPLES):
        if begin:
            deadline.check("retime")
        yield spline.positions(parameters[begin : begin + _NUM_SAMPLES])


def _curves(path: JointPath, options: RetimeOptions) -> Iterator[PathCurve]:
    """Yield curves, the farthest from the path first; with jerk limits also smoothed ones."""
    smoothness = 2 if options.limits_jerk else 1
    max_deviations = _max_deviations(options)
    if options.limits_jerk:
        for max_deviation, curve in smooth_path(path, max_deviations[:-1]):
            yield PathCurve(f"path smoothed within {max_deviation:.3g}", max_deviation, curve)
    # Rounded corners would leave the arcs that a car can drive.
    deviations = max_deviations[-1:] if steering_of(path.group) else max_deviations
    previous: JointSpline | None = None
    for deviation in deviations:
        spline = blend_corners(path, deviation, smoothness)
        if spline != previous:
            name = f"path with corners rounded by {deviation:g}" if deviation else "path itself"
            yield PathCurve(name, deviation, spline)
        previous = spline


def _max_deviations(options: RetimeOptions) -> tuple[float, ...]:
    """Return the largest distances from the path to try, in descending order; the last is 0."""
    largest = options.deviation
    if largest is None:
        return _DEVIATIONS
    return largest, *(smaller for smaller in _DEVIATIONS if smaller < largest)
