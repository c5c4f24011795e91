"""Stops along the path of a motion: q(s(t)) with ds/dt falling from 1 to 0.

Without limits on jerk s'' is constant on short cells, and on each as low as the rows a u + b x <= 1
of all limits allow, with x = s'^2 at the cell's beginning (as in toppra's passes; here the only
pass is forward, from x = 1). With limits on jerk s' falls by an S-curve, at once or after a delay;
of these the one that ends first is taken.
"""

from collections.abc import Iterator, Sequence
from itertools import islice, product, takewhile
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointLimits
from planning.errors import RetimingFailed
from planning.retime.block_peaks import block_norms
from planning.retime.cells import cut_at, even_edges
from planning.retime.compose import compose
from planning.retime.limit_utilization import max_utilization
from planning.retime.limits.path_limit import PathLimit
from planning.retime.profile import SpeedProfile
from planning.retime.toppra.path_rows import acceleration_rows

# Width of cells [s], and their largest number.
_CELL_DURATION, _MAX_CELLS = 4e-3, 600
# Reserves to the joint limits, for peaks between the evaluated parameters of a cell.
_LIMIT_RESERVES = (2e-3, 1e-2, 5e-2)
# Shortest piece [s], and largest squared rate that counts as rest.
_MIN_DURATION, _MAX_REST_RATE = 1e-9, 1e-14
# Durations of S-curves: shortest [s], and ratio of consecutive ones.
_MIN_STOP_DURATION, _DURATION_RATIO = 0.02, 1.12
# Shares of the duration in which s'' ramps up, and down again; and number of initial delays.
_RAMP_SHARES, _NUM_DELAYS = (0.08, 0.2, 0.35, 0.5), 8
_NUM_SAMPLES, _CHUNK_SIZE = 48, 64
# Largest number of stops before the last.
_MAX_STOPS = 12
# Smallest effect of a polynomial term on its piece [rad or m]; smaller terms are left out.
_MIN_TERM = 1e-13


def stops_along(
    running: TimedTrajectory,
    time: float,
    limits: JointLimits,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
    *,
    jerk: bool,
) -> Iterator[TimedTrajectory]:
    """Yield stops along the path of a motion, best first; the last continues to its end.

    Not promised: that they keep the limits between the evaluated parameters.

    Args:
        running: The motion; it ends at rest.
        time: When the stop begins, within the motion [s].
        limits: Joint limits; the motion keeps them.
        path_limits: Other limits that the motion keeps.
        deadline: Time limit.
        jerk: Whether jerk is limited, so that s'' begins and ends at 0.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    remainder = _remainder(running, time)
    make_stops = _s_curve_stops if jerk else _constant_acceleration_stops
    faster_stops = takewhile(
        lambda stop: stop.duration < remainder.duration,
        make_stops(remainder, limits, path_limits, deadline),
    )
    yield from islice(faster_stops, _MAX_STOPS)
    yield remainder


def _remainder(running: TimedTrajectory, time: float) -> TimedTrajectory:
    """Return the remainder of a motion, at least a moment long, without empty pieces."""
    if running.duration - time < _MIN_DURATION:
        coefficients = np.zeros((1, 1, running.coefficients.shape[2]))
        return TimedTrajectory(
            running.joints, np.array([0.0, _MIN_DURATION]), running.end[None], coefficients
        )
    remainder = running.after(time)
    if remainder.breaks[1] < _MIN_DURATION:
        remainder = running.after(time + float(remainder.breaks[1]))
    return remainder


def _edges(remainder: TimedTrajectory) -> Array:
    longest = max(_CELL_DURATION, remainder.duration / _MAX_CELLS)
    return even_edges(
        remainder.breaks, np.ceil(np.diff(remainder.breaks) / longest).astype(np.int64)
    )


def _constant_acceleration_stops(
    remainder: TimedTrajectory,
    limits: JointLimits,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> Iterator[TimedTrajectory]:
    cells = cut_at(remainder, _edges(remainder))
    try:
        path_rows = [limit.rows(cells) for limit in path_limits]
    except RetimingFailed:
        # The robot cannot rest somewhere: the only stop is to finish the motion.
        return
    for reserve in _LIMIT_RESERVES:
        deadline.check("retime")
        rows = [acceleration_rows(cells, limits.scaled(1.0, 1 - reserve)), *path_rows]
        a, b = (np.concatenate(part, axis=1) for part in zip(*rows, strict=True))
        profile = _hardest_braking(cells.breaks, a, b)
        if profile is not None:
            yield _compose_without_small_terms(cells, profile)


def _hardest_braking(edges: Array, a: Array, b: Array) -> SpeedProfile | None:
    """Return the profile of hardest braking within all rows; None if it reaches the end."""
    x, phases, widths = 1.0, list[tuple[float, float, float]](), np.diff(edges)
    for i, width in enumerate(widths):
        slack = 1 - b[i] * x
        down, up = a[i] < 0, a[i] > 0
        lowest = float((slack[down] / a[i][down]).max(initial=-np.inf))
        highest = float((slack[up] / a[i][up]).min(initial=np.inf))
        # Braking does not help where rows cannot be satisfied; the motion itself keeps the limits.
        u = min(lowest, 0.0) if lowest <= highest else 0.0
        rate, after = np.sqrt(x), x + 2 * width * u
        if after <= _MAX_REST_RATE:
            phases.append((rate, u, rate / -u))
            v, accelerations, h = np.array(phases).T
            s = np.append(edges[: i + 1], edges[i] - x / (2 * u))
            return SpeedProfile(s, v, accelerations, np.zeros_like(v), h)
        phases.append((rate, u, 2 * width / (rate + np.sqrt(after))))
        x = after
    return None


def _s_curve_stops(
    remainder: TimedTrajectory,
    limits: JointLimits,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> Iterator[TimedTrajectory]:
    """Yield S-curves that keep the limits at all samples, the soonest end first."""
    delays = np.linspace(0.0, remainder.duration, _NUM_DELAYS + 1)[:-1]
    count = (
        int(np.log(max(remainder.duration / _MIN_STOP_DURATION, 1.0)) / np.log(_DURATION_RATIO)) + 1
    )
    durations = _MIN_STOP_DURATION * _DURATION_RATIO ** np.arange(count + 1)
    candidates = np.array(list(product(delays, durations, range(len(_RAMP_SHARES)))))
    candidates = candidates[candidates[:, :2].sum(axis=1) < remainder.duration]
    candidates = candidates[np.argsort(candidates[:, :2].sum(axis=1), kind="stable")]
    edges = _edges(remainder)
    path = JointSpline(remainder.joints, remainder.breaks, remainder.bases, remainder.coefficients)
    for begin in range(0, len(candidates), _CHUNK_SIZE):
        deadline.check("retime")
        chunk = candidates[begin : begin + _CHUNK_SIZE]
        for delay, duration, ramp in chunk[_keep_joint_limits_at_samples(remainder, limits, chunk)]:
            deadline.check("retime")
            profile = _s_curve(delay, duration, _RAMP_SHARES[int(ramp)] * duration)
            stop = _compose_without_small_terms(path, profile.split_at(edges))
            if _satisfies_limits(stop, limits, path_limits):
                yield stop


def _keep_joint_limits_at_samples(
    remainder: TimedTrajectory, limits: JointLimits, candidates: Array
) -> Any:
    """Return which S-curves keep the joint limits at samples."""
    delays, durations, ramps = candidates.T
    unit = np.stack([_sampled(_s_curve(0.0, 1.0, ramp_share)) for ramp_share in _RAMP_SHARES])
    s, v, a, j = np.moveaxis(unit[ramps.astype(np.int64)], 1, 0)
    delays, durations = delays[:, None], durations[:, None]
    v, a, j = (rate.reshape(-1, 1) for rate in (v, a / durations, j / durations**2))
    first, second, third = (
        remainder.tangents((delays + durations * s).ravel(), order) for order in (1, 2, 3)
    )
    vdot = second * v**2 + first * a
    vddot = third * v**3 + 3 * second * v * a + first * j
    utilizations = [
        (block_norms(rate, limits) / bound).max(axis=1).reshape(len(candidates), -1).max(axis=1)
        for rate, bound in ((vdot, limits.acceleration), (vddot, limits.jerk))
    ]
    return np.maximum(*utilizations) <= 1


def _sampled(profile: SpeedProfile) -> Array:
    """Return s and its derivatives at instants, shape (4, samples)."""
    times = np.linspace(0.0, profile.duration, _NUM_SAMPLES)
    begins = np.cumsum(profile.h) - profile.h
    i = np.searchsorted(begins, times, side="right") - 1
    t, s, v, a, j = times - begins[i], profile.s[i], profile.v[i], profile.a[i], profile.j[i]
    return np.stack([
        s + v * t + a * t**2 / 2 + j * t**3 / 6,
        v + a * t + j * t**2 / 2,
        a + j * t,
        j,
    ])


def _s_curve(delay: float, duration: float, ramp_duration: float) -> SpeedProfile:
    """Return the profile with s' from 1 to 0 after a delay: s'' falls, is constant, rises again."""
    max_deceleration = 1 / (duration - ramp_duration)
    h = np.array([delay, ramp_duration, duration - 2 * ramp_duration, ramp_duration])
    j = np.array([0.0, -max_deceleration / ramp_duration, 0.0, max_deceleration / ramp_duration])
    a = np.array([0.0, 0.0, -max_deceleration, -max_deceleration])
    v = np.append(1.0, 1.0 + np.cumsum(a * h + j * h**2 / 2))[:-1]
    s = np.append(0.0, np.cumsum(v * h + a * h**2 / 2 + j * h**3 / 6))
    is_nonempty = h > _MIN_DURATION
    return SpeedProfile(
        np.append(s[:-1][is_nonempty], s[-1]),
        v[is_nonempty],
        a[is_nonempty],
        j[is_nonempty],
        h[is_nonempty],
    )


def _satisfies_limits(
    motion: TimedTrajectory, limits: JointLimits, path_limits: Sequence[PathLimit]
) -> bool:
    """Return whether a stop keeps the limits on acceleration and jerk, and the path limits."""
    if any(max_utilization(motion, limits, order).fraction > 1 for order in (2, 3)):
        return False
    try:
        utilizations = [
            utilization for limit in path_limits for utilization in limit.utilizations(motion)
        ]
    except RetimingFailed:
        return False
    return all(use.fraction_at(1.0) <= 1 for use in utilizations)


def _compose_without_small_terms(path: JointSpline, profile: SpeedProfile) -> TimedTrajectory:
    """Return the motion along the path, without negligible powers."""
    motion = compose(path, profile)
    powers = np.arange(motion.coefficients.shape[1])
    sizes = np.abs(motion.coefficients).max(axis=2) * profile.h[:, None] ** powers
    counts = np.flatnonzero((sizes > _MIN_TERM).any(axis=0))
    terms = int(counts[-1]) + 1 if len(counts) else 1
    return TimedTrajectory(
        motion.joints, motion.breaks, motion.bases, motion.coefficients[:, :terms]
    )
