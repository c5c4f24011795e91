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
from planning.domain.request.deadline import NO_DEADLINE, Deadline
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointLimits
from planning.errors import RetimingFailed
from planning.retime.block_peaks import block_norms
from planning.retime.limit_utilization import RATES
from planning.retime.limits.path_limit import PathLimit
from planning.retime.retimer import RETIMERS, retime

_NUM_SAMPLES = 400
# Utilization from which a limit counts as binding.
_BINDING_UTILIZATION = 0.97
# Factor by which a limit is raised to measure its saving.
_RELAXATION_FACTOR = 1.2
# Utilization of a limit that is met only for an instant, between samples.
_MET_UTILIZATION = 0.999
# Smallest saving that is reported [s].
_MIN_SAVING = 1e-4
# Largest number of limits with measured savings, those that bind the longest.
_MAX_SAVINGS = 6
# Relative excess over the least duration from which a motion counts as slowed by request.
_SLOWDOWN_TOLERANCE = 1e-8


type _LimitKey = tuple[str, str]


@dataclass(frozen=True)
class _RetimeProblem:
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

    def report(self) -> RetimeReport:
        """Return the report of the fastest timing within the limits."""
        settings = self.limits, self.options, self.path_limits, self.deadline
        return retime(self.spline, *settings)[1]

    def relaxed(self, key: _LimitKey) -> "_RetimeProblem":
        """Return the same problem with one limit relaxed."""
        kind, where = key
        if kind not in RATES:
            path_limits = tuple(
                limit.relaxed(where, _RELAXATION_FACTOR) if limit.name == kind else limit
                for limit in self.path_limits
            )
            return replace(self, path_limits=path_limits)
        values = np.array(getattr(self.limits, kind))
        values[_block_names(self.spline).index(where)] *= _RELAXATION_FACTOR
        return replace(self, limits=replace(self.limits, **{kind: values}))


def explain_duration(
    spline: JointSpline,
    trajectory: TimedTrajectory,
    limits: JointLimits,
    options: RetimeOptions,
    path_limits: Sequence[PathLimit] = (),
    deadline: Deadline = NO_DEADLINE,
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
    problem = _RetimeProblem(
        spline, limits, replace(options, duration=None), tuple(path_limits), deadline
    )
    fastest = problem.report()
    slowed_from = fastest.duration * (1 + _SLOWDOWN_TOLERANCE)
    if options.duration is not None and trajectory.duration > slowed_from:
        return requested_duration_explanation(trajectory.duration)
    intervals = _intervals(trajectory, limits, options, path_limits)
    savings = [
        Saving(*key, _saving(problem.relaxed(key), fastest.duration))
        for key in _binding_limits(intervals, fastest)[:_MAX_SAVINGS]
    ]
    worthwhile = [saving for saving in savings if saving.seconds > _MIN_SAVING]
    worthwhile.sort(key=lambda saving: -saving.seconds)
    return DurationExplanation(intervals, _RELAXATION_FACTOR, tuple(worthwhile))


def requested_duration_explanation(duration: float) -> DurationExplanation:
    """Return the explanation of a motion slowed to a requested duration [s]."""
    whole = BindingInterval(0.0, duration, "duration", "", 1.0)
    return DurationExplanation((whole,), _RELAXATION_FACTOR, ())


def join_explanations(
    parts: Sequence[tuple[DurationExplanation, float]],
) -> DurationExplanation:
    """Return the explanation of consecutive motions, each with its duration [s]."""
    intervals: list[BindingInterval] = []
    seconds: dict[_LimitKey, float] = {}
    begin = 0.0
    for explanation, duration in parts:
        intervals += [
            replace(entry, begin=begin + entry.begin, end=begin + entry.end)
            for entry in explanation.intervals
        ]
        for entry in explanation.savings:
            key = entry.limit, entry.where
            seconds[key] = seconds.get(key, 0.0) + entry.seconds
        begin += duration
    savings = [Saving(*key, saved) for key, saved in seconds.items()]
    savings.sort(key=lambda saving: -saving.seconds)
    return DurationExplanation(tuple(intervals), _RELAXATION_FACTOR, tuple(savings))


def _intervals(
    trajectory: TimedTrajectory,
    limits: JointLimits,
    options: RetimeOptions,
    path_limits: Sequence[PathLimit],
) -> tuple[BindingInterval, ...]:
    times = np.linspace(0.0, trajectory.duration, _NUM_SAMPLES + 1)
    scaled_limits = limits.scaled(options.velocity_scale, options.acceleration_scale)
    utilization = _joint_utilization(
        trajectory, scaled_limits, RETIMERS[options.method].rates, times
    )
    for limit in path_limits:
        for where, values in limit.sampled_utilization(trajectory, times).items():
            utilization[limit.name, where] = values
    keys, table = list(utilization), np.stack(list(utilization.values()), axis=1)
    max_utilization = table.max(axis=1).clip(0.0, 1.0)
    # Odd where a limit is met; -2 where nothing moves.
    codes = np.where(
        max_utilization > 0,
        2 * table.argmax(axis=1) + (max_utilization >= _BINDING_UTILIZATION),
        -2,
    )
    return tuple(
        BindingInterval(
            float(bounds[0]),
            float(bounds[1]),
            *(keys[code // 2] if code >= 0 else ("", "")),
            float(max_utilization[samples].max()),
        )
        for code, samples, bounds in _runs(codes, times)
    )


def _binding_limits(intervals: Sequence[BindingInterval], report: RetimeReport) -> list[_LimitKey]:
    """Return the limits that bind somewhere, the longest binding first."""
    seconds: dict[_LimitKey, float] = {}
    for entry in intervals:
        if entry.share >= _BINDING_UTILIZATION:
            key = entry.limit, entry.where
            seconds[key] = seconds.get(key, 0.0) + entry.end - entry.begin
    for kind, where in report.binding.items():
        if report.utilisation[kind] >= _MET_UTILIZATION:
            seconds.setdefault((kind, where), 0.0)
    return sorted(seconds, key=lambda key: -seconds[key])


def _joint_utilization(
    trajectory: TimedTrajectory, limits: JointLimits, rates: tuple[str, ...], times: Array
) -> dict[_LimitKey, Array]:
    """Return rate over limit at every instant, for every rate and block."""
    utilization: dict[_LimitKey, Array] = {}
    names = _block_names(trajectory)
    for order, rate in enumerate(rates, start=1):
        values = block_norms(trajectory.tangents(times, order), limits) / getattr(limits, rate)
        utilization |= {(rate, name): column for name, column in zip(names, values.T, strict=True)}
    return utilization


def _block_names(curve: Curve) -> list[str]:
    return [name for joint in curve.joints for name, _ in joint.blocks]


def _runs(codes: Any, times: Array) -> list[tuple[int, slice, Array]]:
    """Return runs of equal numbers: the number, its samples, and both instants of the run."""
    cuts = np.flatnonzero(np.diff(codes)) + 1
    first, last = np.concatenate([[0], cuts]), np.append(cuts, len(times))
    edges = np.array([times[0], *((times[cuts - 1] + times[cuts]) / 2), times[-1]])
    return [
        (int(codes[a]), slice(int(a), int(b)), edges[i : i + 2])
        for i, (a, b) in enumerate(zip(first, last, strict=True))
    ]


def _saving(relaxed_problem: _RetimeProblem, duration: float) -> float:
    """Return the time saved by relaxing one limit [s]."""
    try:
        return max(0.0, duration - relaxed_problem.report().duration)
    except RetimingFailed:
        return 0.0
