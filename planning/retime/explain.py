"""Why a motion takes as long as it does: what binds when, and what more of it would save.

Between two instants at which a limit is met, jerk limits often let a motion come near several and
meet none: what is used the most is named all the same, with the share of it that is used.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planning.domain.curves.curve import Curve, JointSpline, TimedTrajectory
from planning.domain.report.duration import BindingInterval, DurationExplanation, Saving
from planning.domain.report.stage_reports import RetimeReport
from planning.domain.request.deadline import UNHURRIED, Deadline
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointLimits
from planning.errors import RetimingFailed
from planning.retime.bounds import block_norms
from planning.retime.limit_utilization import RATES
from planning.retime.limits.path_limit import PathLimit
from planning.retime.retimer import RETIMERS, retime

type Array = np.ndarray[Any, np.dtype[np.float64]]

_SAMPLES = 400
# A limit that is used this much binds.
_BINDS = 0.97
# How much of a limit is added to see what it would save.
_RELAXED = 1.2
# A limit that is met only for an instant, between samples, is used this much.
_MET = 0.999
# Savings that are not worth naming [s].
_LEAST_SAVING = 1e-4
# Savings are measured for so many limits at most, those that bind the longest.
_MOST_SAVINGS = 6
# Durations that are longer by this share were asked for.
_LONGER = 1e-8


type _Named = tuple[str, str]


@dataclass(frozen=True)
class _Task:
    """A path, and what limits its timing.

    Attributes:
        spline: The path.
        limits: Of the joints, unscaled.
        options: Without a duration that is asked for.
        path_limits: Other limits.
        deadline: Time limit.
    """

    spline: JointSpline
    limits: JointLimits
    options: RetimeOptions
    path_limits: tuple[PathLimit, ...]
    deadline: Deadline

    def timed(self) -> RetimeReport:
        """Return how the path is timed, as quickly as the limits allow."""
        how = self.limits, self.options, self.path_limits, self.deadline
        return retime(self.spline, *how)[1]

    def relaxed(self, named: _Named) -> "_Task":
        """Return the same with one limit relaxed."""
        kind, where = named
        if kind not in RATES:
            others = tuple(
                limit.relaxed(where, _RELAXED) if limit.name == kind else limit
                for limit in self.path_limits
            )
            return replace(self, path_limits=others)
        more = np.array(getattr(self.limits, kind))
        more[_block_names(self.spline).index(where)] *= _RELAXED
        return replace(self, limits=replace(self.limits, **{kind: more}))


def explain_duration(
    spline: JointSpline,
    trajectory: TimedTrajectory,
    limits: JointLimits,
    options: RetimeOptions,
    path_limits: Sequence[PathLimit] = (),
    deadline: Deadline = UNHURRIED,
) -> DurationExplanation:
    """Return which limit binds in which interval, and what relaxing each by a fifth would save.

    A saving is measured: the same path is timed again with that limit raised and all others as
    they are. Where a duration was asked for that is longer than the least, that is all there is to
    say: no limit holds the motion back.

    Args:
        spline: The path.
        trajectory: The motion along it, as `retime` made it.
        limits: Unscaled.
        options: With which it was made.
        path_limits: With which it was made.
        deadline: Time limit.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    task = _Task(spline, limits, replace(options, duration=None), tuple(path_limits), deadline)
    least = task.timed()
    if options.duration is not None and trajectory.duration > least.duration * (1 + _LONGER):
        return asked_for(trajectory.duration)
    intervals = _intervals(trajectory, limits, options, path_limits)
    savings = [
        Saving(*named, _saving(task.relaxed(named), least.duration))
        for named in _binding(intervals, least)[:_MOST_SAVINGS]
    ]
    worthwhile = [saving for saving in savings if saving.seconds > _LEAST_SAVING]
    worthwhile.sort(key=lambda saving: -saving.seconds)
    return DurationExplanation(intervals, _RELAXED, tuple(worthwhile))


def asked_for(duration: float) -> DurationExplanation:
    """Return the explanation of a motion that takes longer than it must, as was asked for [s]."""
    whole = BindingInterval(0.0, duration, "duration", "", 1.0)
    return DurationExplanation((whole,), _RELAXED, ())


def joined_explanation(
    parts: Sequence[tuple[DurationExplanation, float]],
) -> DurationExplanation:
    """Return the explanation of motions one after another, each with its duration [s]."""
    intervals: list[BindingInterval] = []
    seconds: dict[_Named, float] = {}
    begin = 0.0
    for explanation, duration in parts:
        intervals += [
            replace(entry, begin=begin + entry.begin, end=begin + entry.end)
            for entry in explanation.intervals
        ]
        for entry in explanation.savings:
            named = entry.limit, entry.where
            seconds[named] = seconds.get(named, 0.0) + entry.seconds
        begin += duration
    savings = [Saving(*named, saved) for named, saved in seconds.items()]
    savings.sort(key=lambda saving: -saving.seconds)
    return DurationExplanation(tuple(intervals), _RELAXED, tuple(savings))


def _intervals(
    trajectory: TimedTrajectory,
    limits: JointLimits,
    options: RetimeOptions,
    path_limits: Sequence[PathLimit],
) -> tuple[BindingInterval, ...]:
    times = np.linspace(0.0, trajectory.duration, _SAMPLES + 1)
    scaled = limits.scaled(options.velocity_scale, options.acceleration_scale)
    used = _used(trajectory, scaled, RETIMERS[options.method].rates, times)
    for limit in path_limits:
        for where, shares in limit.shares(trajectory, times).items():
            used[limit.name, where] = shares
    named, table = list(used), np.stack(list(used.values()), axis=1)
    largest = table.max(axis=1).clip(0.0, 1.0)
    # Odd where it is met; two below what any of them has where nothing moves.
    which = np.where(largest > 0, 2 * table.argmax(axis=1) + (largest >= _BINDS), -2)
    return tuple(
        BindingInterval(
            float(bounds[0]),
            float(bounds[1]),
            *(named[kind // 2] if kind >= 0 else ("", "")),
            float(largest[samples].max()),
        )
        for kind, samples, bounds in _runs(which, times)
    )


def _binding(intervals: Sequence[BindingInterval], report: RetimeReport) -> list[_Named]:
    """Return the limits that are met somewhere, those that are met the longest first."""
    seconds: dict[_Named, float] = {}
    for entry in intervals:
        if entry.share >= _BINDS:
            named = entry.limit, entry.where
            seconds[named] = seconds.get(named, 0.0) + entry.end - entry.begin
    for kind, where in report.binding.items():
        if report.utilisation[kind] >= _MET:
            seconds.setdefault((kind, where), 0.0)
    return sorted(seconds, key=lambda named: -seconds[named])


def _used(
    trajectory: TimedTrajectory, limits: JointLimits, rates: tuple[str, ...], times: Array
) -> dict[_Named, Array]:
    """Return rate over limit at every instant, of every rate and block."""
    used: dict[_Named, Array] = {}
    names = _block_names(trajectory)
    for order, rate in enumerate(rates, start=1):
        shares = block_norms(trajectory.tangents(times, order), limits) / getattr(limits, rate)
        used |= {(rate, name): column for name, column in zip(names, shares.T, strict=True)}
    return used


def _block_names(curve: Curve) -> list[str]:
    return [name for joint in curve.joints for name, _ in joint.blocks]


def _runs(which: Any, times: Array) -> list[tuple[int, slice, Array]]:
    """Return runs of the same number: it, its samples, and from when to when it lasts."""
    cuts = np.flatnonzero(np.diff(which)) + 1
    first, last = np.concatenate([[0], cuts]), np.append(cuts, len(times))
    edges = np.array([times[0], *((times[cuts - 1] + times[cuts]) / 2), times[-1]])
    return [
        (int(which[a]), slice(int(a), int(b)), edges[i : i + 2])
        for i, (a, b) in enumerate(zip(first, last, strict=True))
    ]


def _saving(relaxed: _Task, duration: float) -> float:
    """Return by how much shorter the motion is with one limit relaxed [s]."""
    try:
        return max(0.0, duration - relaxed.timed().duration)
    except RetimingFailed:
        return 0.0
