"""Explanation of a motion's duration: binding limits by interval, and savings from relaxing them.

Between two instants at which a limit is met, jerk limits often let a motion come near several and
meet none: the limit with the largest utilization is named all the same, with its utilization.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planning.domain.arrays import Array
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

_SAMPLES = 400
# Utilization from which a limit counts as binding.
_BINDS = 0.97
# Factor by which a limit is raised to measure its saving.
_RELAXED = 1.2
# Utilization of a limit that is met only for an instant, between samples.
_MET = 0.999
# Smallest saving that is reported [s].
_LEAST_SAVING = 1e-4
# Largest number of limits with measured savings, those that bind the longest.
_MOST_SAVINGS = 6
# Relative excess over the least duration from which a motion counts as slowed by request.
_LONGER = 1e-8


type _Named = tuple[str, str]


@dataclass(frozen=True)
class _Task:
    """A path with its limits and timing options.

    Attributes:
        spline: The path.
        limits: Joint limits, unscaled.
        options: Timing options without a requested duration.
        path_limits: Other limits.
        deadline: Time limit.
    """

    spline: JointSpline
    limits: JointLimits
    options: RetimeOptions
    path_limits: tuple[PathLimit, ...]
    deadline: Deadline

    def timed(self) -> RetimeReport:
        """Return the report of the fastest timing within the limits."""
        how = self.limits, self.options, self.path_limits, self.deadline
        return retime(self.spline, *how)[1]

    def relaxed(self, named: _Named) -> "_Task":
        """Return the task with one limit relaxed."""
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
    """Return the binding limit of each interval, and the saving from relaxing each by a fifth.

    A saving is measured: the same path is timed again with that limit raised and all others
    unchanged. If the requested duration is longer than the least, no limit binds, and the
    explanation says only that.

    Args:
        spline: The path.
        trajectory: The motion along it, made by `retime`.
        limits: Joint limits, unscaled.
        options: Timing options of the motion.
        path_limits: Path limits of the motion.
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
    """Return the explanation of a motion slowed to a requested duration [s]."""
    whole = BindingInterval(0.0, duration, "duration", "", 1.0)
    return DurationExplanation((whole,), _RELAXED, ())


def joined_explanation(
    parts: Sequence[tuple[DurationExplanation, float]],
) -> DurationExplanation:
    """Return the explanation of consecutive motions, each with its duration [s]."""
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
    # Odd where a limit is met; -2 where nothing moves.
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
    """Return the limits that bind somewhere, the longest binding first."""
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
    """Return rate over limit at every instant, for every rate and block."""
    used: dict[_Named, Array] = {}
    names = _block_names(trajectory)
    for order, rate in enumerate(rates, start=1):
        shares = block_norms(trajectory.tangents(times, order), limits) / getattr(limits, rate)
        used |= {(rate, name): column for name, column in zip(names, shares.T, strict=True)}
    return used


def _block_names(curve: Curve) -> list[str]:
    return [name for joint in curve.joints for name, _ in joint.blocks]


def _runs(which: Any, times: Array) -> list[tuple[int, slice, Array]]:
    """Return runs of equal numbers: the number, its samples, and both instants of the run."""
    cuts = np.flatnonzero(np.diff(which)) + 1
    first, last = np.concatenate([[0], cuts]), np.append(cuts, len(times))
    edges = np.array([times[0], *((times[cuts - 1] + times[cuts]) / 2), times[-1]])
    return [
        (int(which[a]), slice(int(a), int(b)), edges[i : i + 2])
        for i, (a, b) in enumerate(zip(first, last, strict=True))
    ]


def _saving(relaxed: _Task, duration: float) -> float:
    """Return the time saved by relaxing one limit [s]."""
    try:
        return max(0.0, duration - relaxed.timed().duration)
    except RetimingFailed:
        return 0.0
