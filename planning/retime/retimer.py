"""retime(): follow a geometric path as quickly as the limits allow, and audit the result."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.report.stage_reports import RetimeReport
from planning.domain.request.deadline import UNHURRIED, Deadline
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointLimits
from planning.errors import ProblemInvalid, RetimingFailed
from planning.retime.compose import compose
from planning.retime.jerk.ruckig_retimer import ruckig_profile
from planning.retime.limit_utilization import RATES, LimitUtilization, largest_use
from planning.retime.limits.path_limit import PathLimit, PathUtilization, uses_of
from planning.retime.profile import SpeedProfile
from planning.retime.smooth_pieces import smooth_pieces
from planning.retime.toppra.toppra_retimer import toppra_profile

type Array = np.ndarray[Any, np.dtype[np.float64]]

# A motion that goes nowhere lasts this long, so that it can be sampled and executed [s].
_HOLD = 1e-3
_STANDSTILL = 1e-9
# The audit leaves everything this far below its limit.
_SPARE = 1e-9
# Stands for rates that are not limited [1/s and powers].
_UNLIMITED = 1e6


@dataclass(frozen=True)
class Retimer:
    """A way to time a path.

    Attributes:
        profile: Times one smooth stretch, from rest to rest.
        smoothness: Continuous derivatives that a stretch must have; where one jumps, it rests.
        rates: Which rates it limits, as attributes of `JointLimits`, by order of derivative.
    """

    profile: Callable[[JointSpline, JointLimits, Sequence[PathLimit], Deadline], SpeedProfile]
    smoothness: int
    rates: tuple[str, ...]


RETIMERS = {
    "ruckig": Retimer(ruckig_profile, 2, RATES),
    "toppra": Retimer(toppra_profile, 1, RATES[:2]),
}


@dataclass(frozen=True)
class _Timed:
    """One stretch.

    Attributes:
        trajectory: Within all limits.
        uses: Of the joints' limits, by order of derivative.
        path_uses: Of the others, by the limit's name.
        raw: How long it was before the audit [s].
    """

    trajectory: TimedTrajectory
    uses: list[LimitUtilization]
    path_uses: list[tuple[str, PathUtilization]]
    raw: float


def retime(
    spline: JointSpline,
    limits: JointLimits,
    options: RetimeOptions,
    path_limits: Sequence[PathLimit] = (),
    deadline: Deadline = UNHURRIED,
) -> tuple[TimedTrajectory, RetimeReport]:
    """Return a trajectory exactly on the spline, from rest to rest, within scaled limits.

    Every stretch between two rests is stretched or compressed in time by what the audit of its
    polynomials says, so that it keeps all limits and meets one of them. A spline that stays where
    it is becomes a rest of a millisecond.

    Args:
        spline: The path; at corners the motion rests.
        limits: Unscaled; the options' factors apply to velocity, and to acceleration and jerk.
        options: Method and factors.
        path_limits: What else limits the motion. toppra is the quickest under them, ruckig keeps
            what it can be told of as it goes; the rest slows its motion between two rests down.
        deadline: Time limit.

    Raises:
        RetimingFailed: The method finds no timing, a joint that must move may not, or the duration
            that is asked for is less than the limits allow.
        ProblemInvalid: A factor is not in (0, 1].
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    for name in ("velocity_scale", "acceleration_scale"):
        if not 0 < getattr(options, name) <= 1:
            message = f"retime.{name} must be in (0, 1], got {getattr(options, name)}"
            raise ProblemInvalid(message, {"field": f"retime.{name}"})
    retimer = RETIMERS[options.method]
    if float(np.abs(spline.coefficients[:, 1:]).max(initial=0.0)) < _STANDSTILL:
        rest = _hold(spline, options.duration or _HOLD)
        return rest, RetimeReport(options.method, rest.duration, 1.0)
    scaled = limits.scaled(options.velocity_scale, options.acceleration_scale)
    usable = _usable(spline, scaled, options.method)
    timed = [
        _timed(stretch, usable, retimer, path_limits, deadline)
        for stretch in smooth_pieces(spline, retimer.smoothness)
    ]
    trajectory = TimedTrajectory.joined([part.trajectory for part in timed])
    slower = _slower(trajectory.duration, options)
    names = _block_names(spline)
    worst = [
        max((part.uses[i] for part in timed), key=lambda use: use.fraction)
        for i in range(len(retimer.rates))
    ]
    delivered = trajectory if slower == 1.0 else trajectory.slowed(slower)
    binding = {rate: names[use.block] for rate, use in zip(retimer.rates, worst, strict=True)}
    utilisation = {
        rate: use.fraction / slower**order
        for order, (rate, use) in enumerate(zip(retimer.rates, worst, strict=True), start=1)
    }
    for name, use in (entry for part in timed for entry in part.path_uses):
        share = use.share(slower)
        if share > utilisation.get(name, -1.0):
            binding[name], utilisation[name] = use.where, share
    return delivered, RetimeReport(
        method=options.method,
        duration=delivered.duration,
        slowed=trajectory.duration / sum(part.raw for part in timed),
        binding=binding,
        utilisation=utilisation,
        stops=len(timed) - 1,
    )


def _timed(
    stretch: JointSpline,
    limits: JointLimits,
    retimer: Retimer,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> _Timed:
    """Return one stretch timed, audited and slowed as the audit demands."""
    deadline.check("retime")
    profile = retimer.profile(stretch, limits, path_limits, deadline)
    raw = compose(stretch, profile)
    uses = [largest_use(raw, limits, order) for order in range(1, len(retimer.rates) + 1)]
    path_uses = uses_of(path_limits, raw, deadline)
    factor = max(use.fraction ** (1 / order) for order, use in enumerate(uses, start=1))
    factor = max(factor, *(use.factor for _, use in path_uses)) if path_uses else factor
    factor *= 1 + _SPARE
    scaled = [
        replace(use, fraction=use.fraction / factor**order)
        for order, use in enumerate(uses, start=1)
    ]
    slowed = [(name, use.slowed(factor)) for name, use in path_uses]
    return _Timed(raw.slowed(factor), scaled, slowed, raw.duration)


def _slower(least: float, options: RetimeOptions) -> float:
    """Return the factor from the least duration to the one that is asked for.

    Raises:
        RetimingFailed: That would be quicker than the limits allow.
    """
    if options.duration is None:
        return 1.0
    if options.duration < least * (1 - _SPARE):
        message = f"the limits allow {least:.4g} s at least, not {options.duration:.4g} s"
        evidence = {"method": options.method, "duration": options.duration, "least": least}
        raise RetimingFailed(message, evidence)
    return max(1.0, options.duration / least)


def _usable(spline: JointSpline, limits: JointLimits, method: str) -> JointLimits:
    """Return limits that are positive and finite numbers for every block.

    Raises:
        RetimingFailed: A block that moves along the spline may not.
    """
    rates = {name: np.asarray(getattr(limits, name)) for name in RATES}
    if all((values > 0).all() and (values <= _UNLIMITED).all() for values in rates.values()):
        return limits
    moving = [bool(spline.coefficients[:, 1:, list(block)].any()) for block in limits.blocks]
    names = _block_names(spline)
    for name, values in rates.items():
        stuck = [names[i] for i in np.flatnonzero(moving & ~(values > 0))]
        if stuck and name in RETIMERS[method].rates:
            message = f"the path moves {', '.join(stuck)}, whose {name} limit is not positive"
            raise RetimingFailed(message, {"method": method, "limit": name, "stuck": stuck})
        rates[name] = np.where(values > 0, np.minimum(values, _UNLIMITED), 1.0)
    return replace(limits, **rates)


def _hold(spline: JointSpline, duration: float) -> TimedTrajectory:
    """Return a rest at the spline's beginning."""
    rest = np.zeros((1, 1, spline.coefficients.shape[2]))
    return TimedTrajectory(spline.joints, np.array([0.0, duration]), spline.start[None], rest)


def _block_names(spline: JointSpline) -> list[str]:
    return [name for joint in spline.joints for name, _ in joint.blocks]
