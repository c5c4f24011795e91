"""Sampled trajectory: sampling instants of a motion, and position, velocity, acceleration there.

A receiver has only samples, and interpolates them by polynomials. If accelerations jump in between,
no polynomial through positions, velocities and accelerations follows them: the one of degree 5
overshoots by 8 % of the jump, however near the samples are. So samples lie where the pieces of the
motion meet, and evenly between; and where accelerations jump there are two, a tenth of a
millisecond apart or so, between which the acceleration is linear in time:

    v1 = v0 + h (a0 + a1) / 2,    p1 = p0 + h v0 + h^2 (2 a0 + a1) / 6.

Where pieces too short for samples of their own lie between, the acceleration is linear up to a
third sample and linear from there on, and its value there is chosen so that v1 is the motion's.

The sampled motion then differs from the exact one by some 1e-9, or 1e-8 where short pieces are
skipped. The samples keep that difference from there on, less a smooth polynomial that removes it by
the end: the first and the last position are the motion's own.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory, derivative
from planning.domain.curves.knots import Knots, evaluate_polynomials
from planning.domain.robot.joints import Joint
from planning.domain.value import Value

# Smallest time between samples, unless the period itself is smaller [s].
_MIN_PERIOD = 1e-3


@dataclass(frozen=True, eq=False)
class Sampling(Value):
    """Rule for the sampling instants of a motion.

    Attributes:
        period: Largest time between samples [s].
        num_points: Number of samples instead, evenly in time; None for the number that the period
            gives.
        is_even: Whether all samples are a period apart, except the last, wherever the pieces meet.
    """

    period: float = 0.01
    num_points: int | None = None
    is_even: bool = False

    @property
    def follows_pieces(self) -> bool:
        """Whether there are samples where the pieces of the motion meet."""
        return self.num_points is None and not self.is_even


@dataclass(frozen=True, eq=False)
class SampledTrajectory(Value):
    """Motion as samples: times, positions, velocities and accelerations.

    Attributes:
        joints: Joints of the coordinates.
        times: From 0, increasing [s], shape (n,).
        positions: [rad or m], shape (n, nq).
        velocities: [rad/s or m/s], shape (n, nv).
        accelerations: [rad/s^2 or m/s^2], shape (n, nv).
    """

    joints: tuple[Joint, ...]
    times: Float64[np.ndarray, " n"]
    positions: Float64[np.ndarray, "n nq"]
    velocities: Float64[np.ndarray, "n nv"]
    accelerations: Float64[np.ndarray, "n nv"]

    @property
    def longest_gap(self) -> float:
        """Longest time between two samples [s]."""
        return float(np.diff(self.times).max())


def sample_trajectory(
    trajectory: TimedTrajectory,
    sampling: Sampling,
    limits: Float64[np.ndarray, " nv"],
    gaps: Float64[np.ndarray, " n"] | None = None,
) -> SampledTrajectory:
    """Return the samples of a motion, the first and the last instant included.

    Args:
        trajectory: The motion.
        sampling: Rule for the instants.
        limits: On the acceleration of every coordinate, infinite for none: they decide which jumps
            are significant [rad/s^2 or m/s^2].
        gaps: Longest time between samples on each piece [s], if that is less than the period, but
            hardly less than a millisecond; not used for evenly spaced samples.
    """
    if not sampling.follows_pieces:
        count = sampling.num_points
        even = None if count is None else trajectory.evenly_spaced_times(count)
        return _exact_samples(
            trajectory, trajectory.sample_times(sampling.period) if even is None else even
        )
    periods = np.full(trajectory.num_pieces, sampling.period)
    if gaps is not None:
        periods = np.minimum(periods, np.maximum(gaps, _MIN_PERIOD))
    knots = Knots.of(trajectory, periods, limits)
    curve, piece, x = trajectory, knots.pieces, knots.times - trajectory.breaks[knots.pieces]
    delta, *rates = (
        evaluate_polynomials(derivative(curve.coefficients, k)[piece], x) for k in range(3)
    )
    if not curve.manifold.is_flat:
        q = curve.manifold.plus(curve.bases[piece], delta)
        v = curve.manifold.generalized_velocity(q, delta, rates[0])
        vdot = curve.manifold.generalized_acceleration(q, delta, *rates)
        return SampledTrajectory(curve.joints, knots.times, q, v, vdot)
    states = curve.bases[piece] + delta, rates[0], rates[1]
    if len(knots.adjusted):
        states = *states[:2], _adjusted_accelerations(curve, knots, states)
    moved = _with_ramps(curve, knots, states) if len(knots.ramps) else states
    return SampledTrajectory(curve.joints, knots.times, *moved)


def _exact_samples(trajectory: TimedTrajectory, times: Array) -> SampledTrajectory:
    rates = trajectory.velocities(times), trajectory.accelerations(times)
    return SampledTrajectory(trajectory.joints, times, trajectory.positions(times), *rates)


def _adjusted_accelerations(
    curve: TimedTrajectory, knots: Knots, states: tuple[Array, Array, Array]
) -> Array:
    """Return the accelerations, with new values at the samples whose acceleration is free.

    Linear between three samples, L and R apart, they integrate to

        v2 - v0 = (L (a0 + a1) + R (a1 + a2)) / 2,

    which is solved for a1; at an end there is one such interval. The values are clipped to the
    range of the motion's accelerations there.
    """
    (_, v, a), times = states, knots.times
    adjusted, last = a.copy(), len(times) - 1
    second_derivative = derivative(curve.coefficients, 2)
    for m in knots.adjusted:
        i, j = max(m - 1, 0), min(m + 1, last)
        before, after = times[m] - times[i], times[j] - times[m]
        target_sum = 2 * (v[j] - v[i]) - before * a[i] - after * a[j]
        rows = slice(0 if m == 0 else knots.pieces[i], knots.pieces[j] + 1)
        begins = second_derivative[rows, 0]
        ends = evaluate_polynomials(second_derivative[rows], curve.widths[rows])
        # Of the piece before only its end counts, of the piece after only its beginning.
        nearby = [begins if m == 0 else begins[1:], ends if m == last else ends[:-1], a[[i, j]]]
        accelerations = np.concatenate(nearby)
        adjusted[m] = np.clip(
            target_sum / (before + after), accelerations.min(axis=0), accelerations.max(axis=0)
        )
    return adjusted


def _with_ramps(
    curve: TimedTrajectory, knots: Knots, states: tuple[Array, Array, Array]
) -> tuple[Array, Array, Array]:
    """Return the states with linear accelerations on ramps, and later states shifted to match."""
    (q, v, a), times = states, knots.times
    i, j = knots.ramps, knots.ramps + 1
    h = (times[j] - times[i])[:, None]
    dv = v[i] + h * (a[i] + a[j]) / 2 - v[j]
    dq = curve.manifold.minus(q[i] + h * v[i] + h**2 * (2 * a[i] + a[j]) / 6, q[j])
    num_ramps_before = np.searchsorted(j, np.arange(len(times)), side="right")
    total_v, total_q, since = (
        np.concatenate([np.zeros_like(part[:1]), np.cumsum(part, axis=0)])[num_ramps_before]
        for part in (dv, dq, dv * times[j][:, None])
    )
    shift_q = total_q + total_v * times[:, None] - since
    correction = _smooth_correction(times, shift_q[-1], total_v[-1])
    return q + shift_q - correction[0], v + total_v - correction[1], a - correction[2]


def _smooth_correction(times: Array, shift: Array, rate: Array) -> tuple[Array, Array, Array]:
    """Return a polynomial from rest at 0 to a shift and a rate, and its derivatives."""
    span = times[-1]
    s = (times / span)[:, None]
    to_shift = (
        s**3 * (10 - 15 * s + 6 * s**2),
        s**2 * (30 - 60 * s + 30 * s**2),
        s * (60 - 180 * s + 120 * s**2),
    )
    to_rate = (
        s**3 * (-4 + 7 * s - 3 * s**2),
        s**2 * (-12 + 28 * s - 15 * s**2),
        s * (-24 + 84 * s - 60 * s**2),
    )
    value, slope, second = (
        (f * shift + g * rate * span) / span**k
        for k, (f, g) in enumerate(zip(to_shift, to_rate, strict=True))
    )
    return value, slope, second
