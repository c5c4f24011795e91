"""Why a motion takes as long as it does: what binds when, and what more of it would save."""

from dataclasses import replace
from typing import Any

import numpy as np

from planning.domain.curve import JointSpline, TimedTrajectory
from planning.domain.duration import BindingInterval, DurationExplanation, Saving
from planning.domain.joints import JointLimits
from planning.domain.options import RetimeOptions
from planning.errors import RetimingFailed
from planning.retime.bounds import block_norms
from planning.retime.retimer import RETIMERS, retime

type Array = np.ndarray[Any, np.dtype[np.float64]]

_SAMPLES = 400
# A limit that is used this much binds.
_BINDS = 0.97
# How much of a limit is added to see what it would save.
_RELAXED = 1.2
# Savings that are not worth naming [s].
_LEAST_SAVING = 1e-4


def explain_duration(
    spline: JointSpline,
    trajectory: TimedTrajectory,
    limits: JointLimits,
    options: RetimeOptions,
) -> DurationExplanation:
    """Return which limit binds in which interval, and what relaxing each by a fifth would save.

    A saving is measured: the same path is timed again with that limit raised and all others as
    they are.

    Args:
        spline: The path.
        trajectory: The motion along it, as `retime` made it.
        limits: Unscaled.
        options: With which it was made.
    """
    rates = RETIMERS[options.method].rates
    scaled = limits.scaled(options.velocity_scale, options.acceleration_scale)
    names = [name for joint in trajectory.joints for name, _ in joint.blocks]
    times = np.linspace(0.0, trajectory.duration, _SAMPLES + 1)
    used = _used(trajectory, scaled, rates, times)
    worst = used.argmax(axis=1)
    binding = np.where(used.max(axis=1) >= _BINDS, worst, -1)
    intervals = [
        BindingInterval(begin, end, *_named(int(which), rates, names))
        for which, begin, end in _runs(binding, times)
    ]
    bound = sorted({int(which) for which in binding if which >= 0})
    free = replace(options, duration=None)
    least, _ = retime(spline, limits, free)
    savings = [
        Saving(*_named(which, rates, names), _saving(spline, limits, free, which, least.duration))
        for which in bound
    ]
    worthwhile = [saving for saving in savings if saving.seconds > _LEAST_SAVING]
    worthwhile.sort(key=lambda saving: -saving.seconds)
    return DurationExplanation(tuple(intervals), _RELAXED, tuple(worthwhile))


def _used(
    trajectory: TimedTrajectory, limits: JointLimits, rates: tuple[str, ...], times: Array
) -> Array:
    """Return rate over limit at every instant, a column for every rate and block in turn."""
    return np.concatenate(
        [
            block_norms(trajectory.tangents(times, order), limits) / getattr(limits, rate)
            for order, rate in enumerate(rates, start=1)
        ],
        axis=1,
    )


def _named(which: int, rates: tuple[str, ...], names: list[str]) -> tuple[str, str]:
    if which < 0:
        return "", ""
    return rates[which // len(names)], names[which % len(names)]


def _runs(binding: Any, times: Array) -> list[tuple[int, float, float]]:
    """Return runs of the same limit: which, and from when to when; they cover the motion."""
    cuts = np.flatnonzero(np.diff(binding)) + 1
    first = np.concatenate([[0], cuts])
    edges = [times[0], *((times[cuts - 1] + times[cuts]) / 2), times[-1]]
    return [
        (int(binding[i]), float(begin), float(end))
        for i, begin, end in zip(first, edges[:-1], edges[1:], strict=True)
    ]


def _saving(
    spline: JointSpline, limits: JointLimits, options: RetimeOptions, which: int, duration: float
) -> float:
    """Return by how much shorter the motion is with one limit relaxed [s]."""
    rates = RETIMERS[options.method].rates
    rate, block = rates[which // len(limits.velocity)], which % len(limits.velocity)
    relaxed = np.array(getattr(limits, rate))
    relaxed[block] *= _RELAXED
    try:
        made, _ = retime(spline, replace(limits, **{rate: relaxed}), options)
    except RetimingFailed:
        return 0.0
    return max(0.0, duration - made.duration)
