"""Stops along the path of a motion: q(s(t)) with s' falling from 1 to 0.

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
from planning.retime.bounds import block_norms
from planning.retime.cells import cut_at, even_edges
from planning.retime.compose import compose
from planning.retime.limit_utilization import largest_use
from planning.retime.limits.path_limit import PathLimit
from planning.retime.profile import SpeedProfile
from planning.retime.toppra.path_rows import acceleration_rows

# Width of cells [s], and their largest number.
_CELL, _MOST_CELLS = 4e-3, 600
# Reserves to the joint limits, for peaks between the evaluated parameters of a cell.
_ROOM = (2e-3, 1e-2, 5e-2)
# Shortest piece [s], and largest squared rate that counts as rest.
_BRIEF, _STANDS = 1e-9, 1e-14
# Durations of S-curves: shortest [s], and ratio of consecutive ones; shares of the duration in
# which s'' ramps up, and down again; and number of initial delays.
_SHORTEST, _STEP, _ONSETS, _WAITS = 0.02, 1.12, (0.08, 0.2, 0.35, 0.5), 8
_SAMPLES, _AT_ONCE = 48, 64
# Largest number of stops before the last.
_MOST = 12
# Smallest effect of a polynomial term on its piece [rad or m]; smaller terms are left out.
_NOTHING = 1e-13


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
    rest = _rest(running, time)
    make = _smooth if jerk else _hardest
    made = takewhile(
        lambda stop: stop.duration < rest.duration, make(rest, limits, path_limits, deadline)
    )
    yield from islice(made, _MOST)
    yield rest


def _rest(running: TimedTrajectory, time: float) -> TimedTrajectory:
    """Return the remainder of a motion, at least a moment long, without empty pieces."""
    if running.duration - time < _BRIEF:
        still = np.zeros((1, 1, running.coefficients.shape[2]))
        return TimedTrajectory(running.joints, np.array([0.0, _BRIEF]), running.end[None], still)
    rest = running.after(time)
    if rest.breaks[1] < _BRIEF:
        rest = running.after(time + float(rest.breaks[1]))
    return rest


def _edges(rest: TimedTrajectory) -> Array:
    longest = max(_CELL, rest.duration / _MOST_CELLS)
    return even_edges(rest.breaks, np.ceil(np.diff(rest.breaks) / longest).astype(np.int64))


def _hardest(
    rest: TimedTrajectory,
    limits: JointLimits,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> Iterator[TimedTrajectory]:
    cells = cut_at(rest, _edges(rest))
    try:
        others = [limit.rows(cells) for limit in path_limits]
    except RetimingFailed:
        # The robot cannot rest somewhere: the only stop is to finish the motion.
        return
    for room in _ROOM:
        deadline.check("retime")
        rows = [acceleration_rows(cells, limits.scaled(1.0, 1 - room)), *others]
        a, b = (np.concatenate(part, axis=1) for part in zip(*rows, strict=True))
        profile = _lowest(cells.breaks, a, b)
        if profile is not None:
            yield _composed(cells, profile)


def _lowest(edges: Array, a: Array, b: Array) -> SpeedProfile | None:
    """Return the profile of hardest braking within all rows; None if it reaches the end."""
    x, phases, widths = 1.0, list[tuple[float, float, float]](), np.diff(edges)
    for i, width in enumerate(widths):
        room = 1 - b[i] * x
        down, up = a[i] < 0, a[i] > 0
        least = float((room[down] / a[i][down]).max(initial=-np.inf))
        most = float((room[up] / a[i][up]).min(initial=np.inf))
        # Braking does not help where rows cannot be satisfied; the motion itself keeps the limits.
        u = min(least, 0.0) if least <= most else 0.0
        rate, after = np.sqrt(x), x + 2 * width * u
        if after <= _STANDS:
            phases.append((rate, u, rate / -u))
            v, push, h = np.array(phases).T
            s = np.append(edges[: i + 1], edges[i] - x / (2 * u))
            return SpeedProfile(s, v, push, np.zeros_like(v), h)
        phases.append((rate, u, 2 * width / (rate + np.sqrt(after))))
        x = after
    return None


def _smooth(
    rest: TimedTrajectory,
    limits: JointLimits,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> Iterator[TimedTrajectory]:
    """Yield S-curves that keep the limits at all samples, the soonest end first."""
    waits = np.linspace(0.0, rest.duration, _WAITS + 1)[:-1]
    count = int(np.log(max(rest.duration / _SHORTEST, 1.0)) / np.log(_STEP)) + 1
    lasting = _SHORTEST * _STEP ** np.arange(count + 1)
    ways = np.array(list(product(waits, lasting, range(len(_ONSETS)))))
    ways = ways[ways[:, :2].sum(axis=1) < rest.duration]
    ways = ways[np.argsort(ways[:, :2].sum(axis=1), kind="stable")]
    edges, path = _edges(rest), JointSpline(rest.joints, rest.breaks, rest.bases, rest.coefficients)
    for begin in range(0, len(ways), _AT_ONCE):
        deadline.check("retime")
        chosen = ways[begin : begin + _AT_ONCE]
        for wait, length, which in chosen[_seem_kept(rest, limits, chosen)]:
            deadline.check("retime")
            profile = _s_curve(wait, length, _ONSETS[int(which)] * length)
            found = _composed(path, profile.split_at(edges))
            if _keeps(found, limits, path_limits):
                yield found


def _seem_kept(rest: TimedTrajectory, limits: JointLimits, ways: Array) -> Any:
    """Return which S-curves keep the joint limits at samples."""
    waits, lengths, which = ways.T
    unit = np.stack([_sampled(_s_curve(0.0, 1.0, onset)) for onset in _ONSETS])
    s, v, a, j = np.moveaxis(unit[which.astype(np.int64)], 1, 0)
    waits, lengths = waits[:, None], lengths[:, None]
    v, a, j = (rate.reshape(-1, 1) for rate in (v, a / lengths, j / lengths**2))
    first, second, third = (
        rest.tangents((waits + lengths * s).ravel(), order) for order in (1, 2, 3)
    )
    vdot = second * v**2 + first * a
    vddot = third * v**3 + 3 * second * v * a + first * j
    uses = [
        (block_norms(rate, limits) / bound).max(axis=1).reshape(len(ways), -1).max(axis=1)
        for rate, bound in ((vdot, limits.acceleration), (vddot, limits.jerk))
    ]
    return np.maximum(*uses) <= 1


def _sampled(profile: SpeedProfile) -> Array:
    """Return s and its derivatives at instants, shape (4, samples)."""
    times = np.linspace(0.0, profile.duration, _SAMPLES)
    begins = np.cumsum(profile.h) - profile.h
    i = np.searchsorted(begins, times, side="right") - 1
    t, s, v, a, j = times - begins[i], profile.s[i], profile.v[i], profile.a[i], profile.j[i]
    return np.stack([
        s + v * t + a * t**2 / 2 + j * t**3 / 6,
        v + a * t + j * t**2 / 2,
        a + j * t,
        j,
    ])


def _s_curve(wait: float, length: float, onset: float) -> SpeedProfile:
    """Return the profile with s' from 1 to 0 after a delay: s'' falls, is constant, rises again."""
    most = 1 / (length - onset)
    h = np.array([wait, onset, length - 2 * onset, onset])
    j = np.array([0.0, -most / onset, 0.0, most / onset])
    a = np.array([0.0, 0.0, -most, -most])
    v = np.append(1.0, 1.0 + np.cumsum(a * h + j * h**2 / 2))[:-1]
    s = np.append(0.0, np.cumsum(v * h + a * h**2 / 2 + j * h**3 / 6))
    lasts = h > _BRIEF
    return SpeedProfile(np.append(s[:-1][lasts], s[-1]), v[lasts], a[lasts], j[lasts], h[lasts])


def _keeps(motion: TimedTrajectory, limits: JointLimits, path_limits: Sequence[PathLimit]) -> bool:
    """Return whether a stop keeps the limits on acceleration and jerk, and the path limits."""
    if any(largest_use(motion, limits, order).fraction > 1 for order in (2, 3)):
        return False
    try:
        uses = [use for limit in path_limits for use in limit.uses(motion)]
    except RetimingFailed:
        return False
    return all(use.share(1.0) <= 1 for use in uses)


def _composed(path: JointSpline, profile: SpeedProfile) -> TimedTrajectory:
    """Return the motion along the path, without negligible powers."""
    made = compose(path, profile)
    powers = np.arange(made.coefficients.shape[1])
    sizes = np.abs(made.coefficients).max(axis=2) * profile.h[:, None] ** powers
    counts = np.flatnonzero((sizes > _NOTHING).any(axis=0))
    terms = int(counts[-1]) + 1 if len(counts) else 1
    return TimedTrajectory(made.joints, made.breaks, made.bases, made.coefficients[:, :terms])
