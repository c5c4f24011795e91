"""Retimer: `retime` times a geometric path as fast as the limits allow, and audits the result."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

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

# Duration of a motion without displacement, so that it can be sampled and executed [s].
_HOLD = 1e-3
_STANDSTILL = 1e-9
# Relative reserve to every limit that the audit leaves.
_SPARE = 1e-9
# Limit that stands for unlimited rates [1/s and powers].
_UNLIMITED = 1e6


@dataclass(frozen=True)
class Retimer:
    """A retiming method.

    Attributes:
        profile: Function that times one smooth piece, from rest to rest.
        smoothness: Number of continuous derivatives that a piece needs; the motion rests elsewhere.
        rates: Limited rates, as attributes of `JointLimits`, by order of derivative.
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
    """One timed smooth piece.

    Attributes:
        trajectory: The motion, within all limits.
        uses: Utilization of the joint limits, by order of derivative.
        path_uses: Utilization of the path limits, by name of the limit.
        raw: Duration before the audit [s].
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

    Every smooth piece between two rests is scaled in time by the factor that the audit of its
    polynomials gives, so that it keeps all limits and meets one of them. A spline without
    displacement becomes a rest of a millisecond.

    Args:
        spline: The path; at corners the motion rests.
        limits: Joint limits, unscaled; the options' factors apply to velocity, and to acceleration
            and jerk.
        options: Method and factors.
        path_limits: Limits other than those of joints. toppra is optimal under them; ruckig handles
            `PeakLimit`s in its profile, and slows the motion between two rests for the others.
        deadline: Time limit.

    Raises:
        RetimingFailed: The method finds no timing, a joint that must move has a limit of zero, or
            the requested duration is less than the limits allow.
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
    """Return one smooth piece timed, audited and slowed by the factor of the audit."""
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
    """Return the ratio of the requested to the least duration.

    Raises:
        RetimingFailed: The requested duration is less than the limits allow.
    """
    if options.duration is None:
        return 1.0
    if options.duration < least * (1 - _SPARE):
        message = f"the limits allow {least:.4g} s at least, not {options.duration:.4g} s"
        evidence = {"method": options.method, "duration": options.duration, "least": least}
        raise RetimingFailed(message, evidence)
    return max(1.0, options.duration / least)


def _usable(spline: JointSpline, limits: JointLimits, method: str) -> JointLimits:
    """Return limits that are positive and finite for every block.

    Raises:
        RetimingFailed: A block that moves along the spline has a limit of zero.
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
