"""Retimer: `retime` times a geometric path as fast as the limits allow, and audits the result."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.report.stage_reports import RetimeReport
from planning.domain.request.deadline import NO_DEADLINE, Deadline
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointLimits
from planning.errors import ProblemInvalid, RetimingFailed
from planning.retime.compose import compose
from planning.retime.jerk.ruckig_retimer import ruckig_profile
from planning.retime.limit_utilization import RATES, LimitUtilization, max_utilization
from planning.retime.limits.path_limit import PathLimit, PathUtilization, path_limit_utilizations
from planning.retime.profile import SpeedProfile
from planning.retime.smooth_pieces import smooth_pieces
from planning.retime.toppra.toppra_retimer import toppra_profile

# Duration of a motion without displacement, so that it can be sampled and executed [s].
_REST_DURATION = 1e-3
_STANDSTILL = 1e-9
# Relative reserve to every limit that the audit leaves.
_LIMIT_RESERVE = 1e-9
# Limit that stands for unlimited rates [1/s and powers].
_MAX_RATE = 1e6


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
class _TimedPiece:
    """One timed smooth piece.

    Attributes:
        trajectory: The motion, within all limits.
        utilizations: Utilization of the joint limits, by order of derivative.
        path_utilizations: Utilization of the path limits, by name of the limit.
        raw_duration: Duration before the audit [s].
    """

    trajectory: TimedTrajectory
    utilizations: list[LimitUtilization]
    path_utilizations: list[tuple[str, PathUtilization]]
    raw_duration: float


def retime(
    spline: JointSpline,
    limits: JointLimits,
    options: RetimeOptions,
    path_limits: Sequence[PathLimit] = (),
    deadline: Deadline = NO_DEADLINE,
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
        rest = _rest_trajectory(spline, options.duration or _REST_DURATION)
        return rest, RetimeReport(options.method, rest.duration, 1.0)
    scaled_limits = limits.scaled(options.velocity_scale, options.acceleration_scale)
    positive_limits = _positive_limits(spline, scaled_limits, options.method)
    timed_pieces = [
        _time_piece(smooth_piece, positive_limits, retimer, path_limits, deadline)
        for smooth_piece in smooth_pieces(spline, retimer.smoothness)
    ]
    trajectory = TimedTrajectory.joined([part.trajectory for part in timed_pieces])
    time_scaling = _requested_time_scaling(trajectory.duration, options)
    names = _block_names(spline)
    max_utilizations = [
        max((part.utilizations[i] for part in timed_pieces), key=lambda use: use.fraction)
        for i in range(len(retimer.rates))
    ]
    result = trajectory if time_scaling == 1.0 else trajectory.time_scaled(time_scaling)
    binding = {
        rate: names[use.block] for rate, use in zip(retimer.rates, max_utilizations, strict=True)
    }
    utilisation = {
        rate: use.fraction / time_scaling**order
        for order, (rate, use) in enumerate(
            zip(retimer.rates, max_utilizations, strict=True), start=1
        )
    }
    for name, use in [entry for part in timed_pieces for entry in part.path_utilizations]:
        fraction = use.fraction_at(time_scaling)
        if fraction > utilisation.get(name, -1.0):
            binding[name], utilisation[name] = use.where, fraction
    return result, RetimeReport(
        method=options.method,
        duration=result.duration,
        slowed=trajectory.duration / sum(part.raw_duration for part in timed_pieces),
        binding=binding,
        utilisation=utilisation,
        stops=len(timed_pieces) - 1,
    )


def _time_piece(
    smooth_piece: JointSpline,
    limits: JointLimits,
    retimer: Retimer,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> _TimedPiece:
    """Return one smooth piece timed, audited and slowed by the factor of the audit."""
    deadline.check("retime")
    profile = retimer.profile(smooth_piece, limits, path_limits, deadline)
    raw = compose(smooth_piece, profile)
    utilizations = [
        max_utilization(raw, limits, order) for order in range(1, len(retimer.rates) + 1)
    ]
    path_utilizations = path_limit_utilizations(path_limits, raw, deadline)
    time_scaling = max(
        use.fraction ** (1 / order) for order, use in enumerate(utilizations, start=1)
    )
    time_scaling = max([time_scaling, *(use.time_scaling for _, use in path_utilizations)])
    time_scaling *= 1 + _LIMIT_RESERVE
    scaled = [
        replace(use, fraction=use.fraction / time_scaling**order)
        for order, use in enumerate(utilizations, start=1)
    ]
    slowed = [(name, use.slowed(time_scaling)) for name, use in path_utilizations]
    return _TimedPiece(raw.time_scaled(time_scaling), scaled, slowed, raw.duration)


def _requested_time_scaling(min_duration: float, options: RetimeOptions) -> float:
    """Return the ratio of the requested to the least duration.

    Raises:
        RetimingFailed: The requested duration is less than the limits allow.
    """
    if options.duration is None:
        return 1.0
    if options.duration < min_duration * (1 - _LIMIT_RESERVE):
        message = (
            f"the requested duration of {options.duration:.4g} s is shorter than the minimum of "
            f"{min_duration:.4g} s within the limits"
        )
        evidence = {"method": options.method, "duration": options.duration, "least": min_duration}
        raise RetimingFailed(message, evidence)
    return max(1.0, options.duration / min_duration)


def _positive_limits(spline: JointSpline, limits: JointLimits, method: str) -> JointLimits:
    """Return limits that are positive and finite for every block.

    Raises:
        RetimingFailed: A block that moves along the spline has a limit of zero.
    """
    rates = {name: np.asarray(getattr(limits, name)) for name in RATES}
    if all((values > 0).all() and (values <= _MAX_RATE).all() for values in rates.values()):
        return limits
    moving = [bool(spline.coefficients[:, 1:, list(block)].any()) for block in limits.blocks]
    names = _block_names(spline)
    for name, values in rates.items():
        stuck = [names[i] for i in np.flatnonzero(moving & ~(values > 0))]
        if stuck and name in RETIMERS[method].rates:
            message = f"{', '.join(stuck)} must have a positive {name} limit to move along the path"
            raise RetimingFailed(message, {"method": method, "limit": name, "stuck": stuck})
        rates[name] = np.where(values > 0, np.minimum(values, _MAX_RATE), 1.0)
    return replace(limits, **rates)


def _rest_trajectory(spline: JointSpline, duration: float) -> TimedTrajectory:
    """Return a rest at the spline's beginning."""
    rest = np.zeros((1, 1, spline.coefficients.shape[2]))
    return TimedTrajectory(spline.joints, np.array([0.0, duration]), spline.start[None], rest)


def _block_names(spline: JointSpline) -> list[str]:
    return [name for joint in spline.joints for name, _ in joint.blocks]
