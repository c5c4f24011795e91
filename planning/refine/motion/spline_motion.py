"""SplineMotion: control points and duration of a clamped uniform cubic spline in time."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.curves.bspline_basis import basis_weights
from planning.refine.curves.chart import Chart
from planning.refine.curves.path_velocity import path_grid
from planning.refine.motion.spline_matrices import matrices_at

# Control points at either end that are the same: the motion rests there, ...
NUM_REST_POINTS = 2
# ... and has no acceleration there either, where jerk counts.
NUM_SMOOTH_REST_POINTS = 3
_NUM_FIT_SAMPLES = 241


@dataclass(frozen=True)
class SplineMotion:
    """Motion q(t) = r(t / T).

    Attributes:
        points: Control points of r, in the coordinates of a chart, shape (k, nq).
        duration: T [s].
    """

    points: Float64[np.ndarray, "k nq"]
    duration: float

    def with_ends_of(self, path: Array, count: int) -> "SplineMotion":
        """Return the motion with its first and last `count` control points at the path's ends."""
        points = self.points.copy()
        points[:count], points[-count:] = path[0], path[-1]
        return SplineMotion(points, self.duration)

    def toward(self, other: "SplineMotion", share: float) -> "SplineMotion":
        """Return the motion a share of the way to another one with as many control points."""
        return SplineMotion(
            self.points + share * (other.points - self.points),
            self.duration + share * (other.duration - self.duration),
        )

    def trajectory(self, chart: Chart) -> TimedTrajectory:
        """Return the motion in time."""
        curve = chart.curve(self.points)
        unit = TimedTrajectory(curve.joints, curve.breaks, curve.bases, curve.coefficients)
        return unit.time_scaled(self.duration)


def fit_motion(
    points: Float64[np.ndarray, "k nq"],
    path_velocity: Float64[np.ndarray, " n_plus_1"],
    num_control_points: int,
    num_rest_points: int,
) -> SplineMotion:
    """Return the spline motion nearest to a curve with its path velocity, by least squares.

    Args:
        points: Control points of the curve r(s).
        path_velocity: b = (ds/dt)^2 at the points of its grid [1/s^2].
        num_control_points: Of the motion.
        num_rest_points: Control points at either end that are the same.
    """
    s = _instants(points, path_velocity)
    duration, fractions = s[0], s[1]
    targets = basis_weights(len(points), fractions).apply(points)
    matrix = matrices_at(num_control_points, np.linspace(0, 1, len(fractions))).by_order[0]
    fitted = np.empty((num_control_points, points.shape[1]))
    ends = slice(num_rest_points, num_control_points - num_rest_points)
    fitted[: ends.start], fitted[ends.stop :] = points[0], points[-1]
    fixed = matrix[:, : ends.start] @ fitted[: ends.start]
    fixed += matrix[:, ends.stop :] @ fitted[ends.stop :]
    fitted[ends] = np.linalg.lstsq(matrix[:, ends], targets - fixed)[0]
    return SplineMotion(fitted, duration)


def _instants(points: Array, b: Array) -> tuple[float, Array]:
    """Return the duration, and s at evenly spaced instants: on an interval s is quadratic in t."""
    step, root = path_grid(len(points)).step, np.sqrt(b)
    widths = 2 * step / (root[1:] + root[:-1])
    begins = np.concatenate([[0.0], np.cumsum(widths)])
    times = np.linspace(0.0, begins[-1], _NUM_FIT_SAMPLES)
    i = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(widths) - 1)
    local = times - begins[i]
    s = i * step + root[i] * local + np.diff(b)[i] / (4 * step) * local**2
    return float(begins[-1]), np.clip(s, 0.0, 1.0)


def rate_time_scaling(motion: SplineMotion, bounds: RateBounds) -> float:
    """Return the least time scaling with which a motion keeps bounds on its rates.

    Accelerations and jerks of a cubic are largest at its knots; velocities are sampled.
    """
    spans = len(motion.points) - 3
    knots = np.linspace(0.0, 1.0, 4 * spans + 1)
    by_order = matrices_at(len(motion.points), knots).by_order
    rates = [by_order[k] @ motion.points / motion.duration**k for k in range(1, 4)]
    ranges = [
        np.array([[-1.0], [1.0]]) * bounds.velocity,
        bounds.acceleration_range * bounds.acceleration,
        None if bounds.jerk is None else np.array([[-1.0], [1.0]]) * bounds.jerk,
    ]
    return max(
        float((rate[:, None] / bound).max()) ** (1 / k)
        for k, (rate, bound) in enumerate(zip(rates, ranges, strict=True), start=1)
        if bound is not None
    )
