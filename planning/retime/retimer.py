"""retime(): follow a geometric path as quickly as the limits allow, and audit the result."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from planning.domain.curve import JointSpline, TimedTrajectory
from planning.domain.joints import JointLimits
from planning.domain.options import RetimeOptions
from planning.domain.report import RetimeReport
from planning.errors import ProblemInvalid
from planning.retime.bounds import block_peaks
from planning.retime.compose import compose
from planning.retime.profile import SpeedProfile
from planning.retime.ruckig_retimer import ruckig_profile
from planning.retime.stretches import smooth_stretches
from planning.retime.toppra_retimer import toppra_profile

type Array = np.ndarray[Any, np.dtype[np.float64]]

# A motion that goes nowhere lasts this long, so that it can be sampled and executed [s].
_HOLD = 1e-3
_STANDSTILL = 1e-9
# The audit stretches until everything is this far below its limit.
_SPARE = 1e-9


@dataclass(frozen=True)
class Retimer:
    """A way to time a path.

    Attributes:
        profile: Times one smooth stretch, from rest to rest.
        smoothness: Continuous derivatives that a stretch must have; where one jumps, it rests.
        rates: Which rates it limits, as attributes of `JointLimits`, by order of derivative.
    """

    profile: Callable[[JointSpline, JointLimits], SpeedProfile]
    smoothness: int
    rates: tuple[str, ...]


RETIMERS = {
    "ruckig": Retimer(ruckig_profile, 2, ("velocity", "acceleration", "jerk")),
    "toppra": Retimer(toppra_profile, 1, ("velocity", "acceleration")),
}


def retime(
    spline: JointSpline, limits: JointLimits, options: RetimeOptions
) -> tuple[TimedTrajectory, RetimeReport]:
    """Return a trajectory exactly on the spline, from rest to rest, within scaled limits.

    Args:
        spline: The path; at corners the motion rests.
        limits: Unscaled; the options' factors apply to velocity, and to acceleration and jerk.
        options: Method and factors.

    Raises:
        RetimingFailed: The method finds no timing.
        ProblemInvalid: A factor is not in (0, 1].
    """
    for name in ("velocity_scale", "acceleration_scale"):
        if not 0 < getattr(options, name) <= 1:
            message = f"retime.{name} must be in (0, 1], got {getattr(options, name)}"
            raise ProblemInvalid(message, {"field": f"retime.{name}"})
    retimer = RETIMERS[options.method]
    scaled = limits.scaled(options.velocity_scale, options.acceleration_scale)
    if float(np.abs(spline.coefficients[:, 1:]).max(initial=0.0)) < _STANDSTILL:
        return _hold(spline), RetimeReport(options.method, _HOLD, 1.0)
    stretches = smooth_stretches(spline, retimer.smoothness)
    parts: list[TimedTrajectory] = []
    for stretch in stretches:
        profile = retimer.profile(stretch, scaled).split_at(stretch.breaks[1:-1])
        parts.append(compose(stretch, profile))
    trajectory = _joined(parts)
    peaks = _utilisation(trajectory, scaled, retimer)
    factor = max(float(use.max()) ** (1 / order) for order, use in enumerate(peaks, start=1)) * (
        1 + _SPARE
    )
    factor = max(factor, 1.0)
    if factor > 1:
        trajectory = trajectory.slowed(factor)
    names = _block_names(spline)
    return trajectory, RetimeReport(
        method=options.method,
        duration=trajectory.duration,
        slowed=factor,
        binding={
            rate: names[int(np.argmax(use))] for rate, use in zip(retimer.rates, peaks, strict=True)
        },
        utilisation={
            rate: float(use.max()) / factor**order
            for order, (rate, use) in enumerate(zip(retimer.rates, peaks, strict=True), start=1)
        },
        stops=len(stretches) - 1,
    )


def _utilisation(trajectory: TimedTrajectory, limits: JointLimits, retimer: Retimer) -> list[Array]:
    """Return peak over limit per block, for each rate that is limited."""
    return [
        block_peaks(trajectory, limits, order).max(axis=0) / getattr(limits, rate)
        for order, rate in enumerate(retimer.rates, start=1)
    ]


def _joined(parts: list[TimedTrajectory]) -> TimedTrajectory:
    """Return the parts one after another."""
    degree = max(part.coefficients.shape[1] for part in parts)
    padded = [
        np.pad(part.coefficients, ((0, 0), (0, degree - part.coefficients.shape[1]), (0, 0)))
        for part in parts
    ]
    starts = np.cumsum([0.0, *(part.duration for part in parts)])
    breaks = [part.breaks[:-1] + begin for part, begin in zip(parts, starts[:-1], strict=True)]
    return TimedTrajectory(
        parts[0].joints,
        np.append(np.concatenate(breaks), starts[-1]),
        np.concatenate([part.bases for part in parts]),
        np.concatenate(padded),
    )


def _hold(spline: JointSpline) -> TimedTrajectory:
    """Return a moment of rest at the spline's beginning."""
    rest = np.zeros((1, 1, spline.coefficients.shape[2]))
    return TimedTrajectory(spline.joints, np.array([0.0, _HOLD]), spline.start[None], rest)


def _block_names(spline: JointSpline) -> list[str]:
    return [name for joint in spline.joints for name, _ in joint.blocks]
