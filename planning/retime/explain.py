"""Why a motion takes as long as it does: what binds when, and what more of it would save."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planning.domain.curve import Curve, JointSpline, TimedTrajectory
from planning.domain.duration import BindingInterval, DurationExplanation, Saving
from planning.domain.joints import JointLimits
from planning.domain.options import RetimeOptions
from planning.errors import RetimingFailed
from planning.retime.audit import RATES
from planning.retime.bounds import block_norms
from planning.retime.path_limit import PathLimit
from planning.retime.retimer import RETIMERS, retime

type Array = np.ndarray[Any, np.dtype[np.float64]]

_SAMPLES = 400
# A limit that is used this much binds.
_BINDS = 0.97
# How much of a limit is added to see what it would save.
_RELAXED = 1.2
# Savings that are not worth naming [s].
_LEAST_SAVING = 1e-4


type _Named = tuple[str, str]


@dataclass(frozen=True)
class _Task:
    """A path, and what limits its timing.

    Attributes:
        spline: The path.
        limits: Of the joints, unscaled.
        options: Without a duration that is asked for.
        path_limits: Other limits.
    """

    spline: JointSpline
    limits: JointLimits
    options: RetimeOptions
    path_limits: tuple[PathLimit, ...]

    @property
    def duration(self) -> float:
        """The least that the limits allow [s]."""
        return retime(self.spline, self.limits, self.options, self.path_limits)[0].duration

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
) -> DurationExplanation:
    """Return which limit binds in which interval, and what relaxing each by a fifth would save.

    A saving is measured: the same path is timed again with that limit raised and all others as
    they are.

    Args:
        spline: The path.
        trajectory: The motion along it, as `retime` made it.
        limits: Unscaled.
        options: With which it was made.
        path_limits: With which it was made.
    """
    intervals = _intervals(trajectory, limits, options, path_limits)
    task = _Task(spline, limits, replace(options, duration=None), tuple(path_limits))
    least = task.duration
    bound = dict.fromkeys((entry.limit, entry.where) for entry in intervals if entry.limit)
    savings = [Saving(*named, _saving(task.relaxed(named), least)) for named in bound]
    worthwhile = [saving for saving in savings if saving.seconds > _LEAST_SAVING]
    worthwhile.sort(key=lambda saving: -saving.seconds)
    return DurationExplanation(intervals, _RELAXED, tuple(worthwhile))


def explain_slowed(
    explanation: DurationExplanation,
    trajectory: TimedTrajectory,
    limits: JointLimits,
    options: RetimeOptions,
    path_limits: Sequence[PathLimit] = (),
) -> DurationExplanation:
    """Return the explanation of a motion that was slowed as a whole since.

    Args:
        explanation: Of the motion as it was.
        trajectory: The motion as it is.
        limits: Unscaled.
        options: With which it was made.
        path_limits: With which it was made.
    """
    intervals = _intervals(trajectory, limits, options, path_limits)
    bound = {(entry.limit, entry.where) for entry in intervals}
    savings = tuple(entry for entry in explanation.savings if (entry.limit, entry.where) in bound)
    return replace(explanation, intervals=intervals, savings=savings)


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
    binding = np.where(table.max(axis=1) >= _BINDS, table.argmax(axis=1), -1)
    return tuple(
        BindingInterval(begin, end, *(named[which] if which >= 0 else ("", "")))
        for which, begin, end in _runs(binding, times)
    )


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


def _runs(binding: Any, times: Array) -> list[tuple[int, float, float]]:
    """Return runs of the same limit: which, and from when to when; they cover the motion."""
    cuts = np.flatnonzero(np.diff(binding)) + 1
    first = np.concatenate([[0], cuts])
    edges = [times[0], *((times[cuts - 1] + times[cuts]) / 2), times[-1]]
    return [
        (int(binding[i]), float(begin), float(end))
        for i, begin, end in zip(first, edges[:-1], edges[1:], strict=True)
    ]


def _saving(relaxed: _Task, duration: float) -> float:
    """Return by how much shorter the motion is with one limit relaxed [s]."""
    try:
        return max(0.0, duration - relaxed.duration)
    except RetimingFailed:
        return 0.0
