"""Samples of a motion: at which instants it is told, and the numbers that are told there.

A receiver knows nothing but samples, and takes the motion between two of them for a polynomial. If
accelerations jump in between, no polynomial through positions, velocities and accelerations follows
them: the one of degree 5 overshoots by 8 % of the jump, however near the samples are. So samples
lie where the pieces of the motion meet, and evenly between; and where accelerations jump there are
two, a tenth of a millisecond apart or so, between which the acceleration goes over linearly:

    v1 = v0 + h (a0 + a1) / 2,    p1 = p0 + h v0 + h^2 (2 a0 + a1) / 6.

What the true motion has then differs by some 1e-9. The samples keep that difference from there on,
less a smooth polynomial that takes it away by the end: the first and the last are the motion's own.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.curve import TimedTrajectory, derivative
from planning.domain.joints import Joint
from planning.domain.value import Value

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]

# Half of the time in which a jump of acceleration is gone over, at least [s].
_RAMP = 5e-5
# Jumps that count as such, and what rounding may change of an acceleration, over their limits.
_JUMP, _ROUNDED = 1e-6, 2e-7
# Samples are not put nearer than this but for the period [s].
_SHORTEST = 1e-3
# The largest second derivative of the polynomial of degree 5 on [0, 1] that goes from 0 to 1.
_STEEPEST = 10 / np.sqrt(3)
# What is shorter, at an end, is part of the piece beside it [s].
_DUST = 3e-8
# Pieces of fewer ramps than this are gone over as a whole.
_NARROW = 4.0


@dataclass(frozen=True, eq=False)
class Sampling(Value):
    """Which instants of a motion are told.

    Attributes:
        period: Between samples at most [s].
        num_points: So many instead, evenly in time; None for as many as the period makes.
        is_even: Whether all are a period apart, but for the last, wherever the pieces meet.
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
    """A motion as it is told.

    Attributes:
        joints: Whose.
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
        """Between two samples [s]."""
        return float(np.diff(self.times).max())


def sampled(
    trajectory: TimedTrajectory,
    sampling: Sampling,
    limits: Float64[np.ndarray, " nv"],
    gaps: Float64[np.ndarray, " n"] | None = None,
) -> SampledTrajectory:
    """Return the samples of a motion, the first and the last instant included.

    Args:
        trajectory: The motion.
        sampling: Which instants.
        limits: On the acceleration of every coordinate, infinite for none: they say which jumps
            count [rad/s^2 or m/s^2].
        gaps: Longest time between samples on each piece [s], if it is less than the period, but
            hardly less than a millisecond; not for samples that are evenly apart.
    """
    if not sampling.follows_pieces:
        count = sampling.num_points
        even = None if count is None else trajectory.even_times(count)
        return _at(trajectory, trajectory.sample_times(sampling.period) if even is None else even)
    periods = np.full(trajectory.num_pieces, sampling.period)
    if gaps is not None:
        periods = np.minimum(periods, np.maximum(gaps, _SHORTEST))
    knots = _Knots.of(trajectory, periods, limits)
    curve, piece, x = trajectory, knots.pieces, knots.times - trajectory.breaks[knots.pieces]
    delta, *rates = (_evaluated(derivative(curve.coefficients, k)[piece], x) for k in range(3))
    if not curve.manifold.is_flat:
        q = curve.manifold.plus(curve.bases[piece], delta)
        v = curve.manifold.generalized_velocity(q, delta, rates[0])
        vdot = curve.manifold.generalized_acceleration(q, delta, *rates)
        return SampledTrajectory(curve.joints, knots.times, q, v, vdot)
    states = curve.bases[piece] + delta, rates[0], rates[1]
    moved = _ramped(curve, knots, states) if len(knots.ramps) else states
    return SampledTrajectory(curve.joints, knots.times, *moved)


def _at(trajectory: TimedTrajectory, times: Array) -> SampledTrajectory:
    rates = trajectory.velocities(times), trajectory.accelerations(times)
    return SampledTrajectory(trajectory.joints, times, trajectory.positions(times), *rates)


@dataclass(frozen=True)
class _Knots:
    """Instants, the piece of the motion that each belongs to, and which begin a ramp."""

    times: Array
    pieces: Indices
    ramps: Indices

    @classmethod
    def of(cls, curve: TimedTrajectory, periods: Array, limits: Array) -> "_Knots":
        breaks, widths = curve.breaks, np.diff(curve.breaks)
        ramp = _ramp(curve, limits)
        long = np.flatnonzero(widths >= _NARROW * ramp)
        if len(long) == 0:
            ends = np.array([0, curve.num_pieces - 1])
            return cls(breaks[[0, -1]], ends, np.zeros(0, dtype=np.intp))
        # Before the first long piece, between all, and after the last.
        jumps = np.diff(long, prepend=-1, append=curve.num_pieces) > 1
        jumps[1:-1] |= _jumps(curve, limits, long)
        begins = breaks[long] + ramp * jumps[:-1]
        ends = breaks[long + 1] - ramp * jumps[1:]
        if breaks[long[0]] <= _DUST:
            begins[0], jumps[0] = 0.0, False
        if breaks[-1] - breaks[long[-1] + 1] <= _DUST:
            ends[-1], jumps[-1] = breaks[-1], False
        counts = np.maximum(1, np.ceil((ends - begins) / periods[long] - 1e-9)).astype(np.intp)
        has_end = np.append(jumps[1:-1], True)
        number = counts + has_end
        owner = np.repeat(np.arange(len(long)), number)
        step = np.arange(len(owner)) - (np.cumsum(number) - number)[owner]
        times = begins[owner] + step * ((ends - begins) / counts)[owner]
        lasts = np.cumsum(number) - 1
        times[lasts[has_end]] = ends[has_end]
        pieces, ramps = long[owner], lasts[:-1][jumps[1:-1]]
        if jumps[0]:
            times, pieces = np.insert(times, 0, 0.0), np.insert(pieces, 0, 0)
            ramps = np.insert(ramps + 1, 0, 0)
        if jumps[-1]:
            ramps = np.append(ramps, len(times) - 1)
            times, pieces = np.append(times, breaks[-1]), np.append(pieces, curve.num_pieces - 1)
        return cls(times, pieces, ramps)


def _ramp(curve: TimedTrajectory, limits: Array) -> float:
    """Return half of how long a ramp takes: so long that rounded positions do not bend it [s]."""
    if not curve.manifold.is_flat:
        return 0.0
    ulp = np.spacing(np.abs(curve.bases).max(axis=0))
    least = np.sqrt(_STEEPEST * ulp / (_ROUNDED * limits))
    return max(_RAMP, float(least.max()) / 2)


def _jumps(curve: TimedTrajectory, limits: Array, long: Indices) -> Any:
    """Return where accelerations jump between two long pieces in a row."""
    if not curve.manifold.is_flat:
        return np.zeros(len(long) - 1, dtype=bool)
    bend = derivative(curve.coefficients, 2)
    before = _evaluated(bend[long[:-1]], np.diff(curve.breaks)[long[:-1]])
    return (np.abs(bend[long[1:], 0] - before) > _JUMP * limits).any(axis=1)


def _ramped(
    curve: TimedTrajectory, knots: _Knots, states: tuple[Array, Array, Array]
) -> tuple[Array, Array, Array]:
    """Return the states with linear accelerations on ramps, and all else moved along."""
    (q, v, a), times = states, knots.times
    i, j = knots.ramps, knots.ramps + 1
    h = (times[j] - times[i])[:, None]
    dv = v[i] + h * (a[i] + a[j]) / 2 - v[j]
    dq = curve.manifold.minus(q[i] + h * v[i] + h**2 * (2 * a[i] + a[j]) / 6, q[j])
    began = np.searchsorted(j, np.arange(len(times)), side="right")
    total_v, total_q, since = (
        np.concatenate([np.zeros_like(part[:1]), np.cumsum(part, axis=0)])[began]
        for part in (dv, dq, dv * times[j][:, None])
    )
    moved_q = total_q + total_v * times[:, None] - since
    back = _smooth(times, moved_q[-1], total_v[-1])
    return q + moved_q - back[0], v + total_v - back[1], a - back[2]


def _smooth(times: Array, shift: Array, rate: Array) -> tuple[Array, Array, Array]:
    """Return a polynomial that comes from rest at 0 to a shift and a rate, and its derivatives."""
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
    value, slope, bend = (
        (f * shift + g * rate * span) / span**k
        for k, (f, g) in enumerate(zip(to_shift, to_rate, strict=True))
    )
    return value, slope, bend


def _evaluated(coefficients: Float64[np.ndarray, "m k nv"], x: Float64[np.ndarray, " m"]) -> Array:
    """Return the value of a polynomial each, lowest power first, shape (m, nv)."""
    total = coefficients[:, -1].copy()
    for k in range(coefficients.shape[1] - 2, -1, -1):
        total = total * x[:, None] + coefficients[:, k]
    return total
