"""Retimer: `retime` times a geometric path as fast as the limits allow, and audits the result."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.curves.curve import Curve, JointSpline, TimedTrajectory
from planning.domain.report.stage_reports import RetimeReport
from planning.domain.request.deadline import NO_DEADLINE, Deadline
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointLimits
from planning.errors import ProblemInvalid, RetimingFailed
from planning.retime.compose import compose
from planning.retime.jerk.ruckig_retimer import ruckig_profile
from planning.retime.limit_utilization import RATES
from planning.retime.limits.path_limit import PathLimit
from planning.retime.limits.timed_piece import TimedPiece, audited, block_names, joined
from planning.retime.profile import SpeedProfile
from planning.retime.smooth_pieces import smooth_pieces
from planning.retime.toppra.kernel_retimer import timed_by_kernel
from planning.retime.toppra.toppra_retimer import toppra_profile

# Duration of a motion without displacement, so that it can be sampled and executed [s].
_REST_DURATION = 1e-3
_STANDSTILL = 1e-9
# Largest time scaling of a motion that keeps its own time.
_KEPT_TIME_SCALING = 1.005
# Limit that stands for unlimited rates [1/s and powers].
_MAX_RATE = 1e6


@dataclass(frozen=True)
class Retimer:
    """A retiming method.

    Attributes:
        profile: Function that times one smooth piece, from rest to rest.
        smoothness: Number of continuous derivatives that a piece needs; the motion rests elsewhere.
        rates: Limited rates, as attributes of `JointLimits`, by order of derivative.
        timed_at_once: Function that times and audits all smooth pieces under joint limits alone;
            it returns None where it cannot.
    """

    profile: Callable[[JointSpline, JointLimits, Sequence[PathLimit], Deadline], SpeedProfile]
    smoothness: int
    rates: tuple[str, ...]
    timed_at_once: Callable[[JointSpline, JointLimits], list[TimedPiece] | None] | None = None


RETIMERS = {
    "ruckig": Retimer(ruckig_profile, 2, RATES),
    "toppra": Retimer(toppra_profile, 1, RATES[:2], timed_by_kernel),
}


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
    timed_pieces = None
    if retimer.timed_at_once and not path_limits:
        deadline.check("retime")
        timed_pieces = retimer.timed_at_once(spline, positive_limits)
        deadline.check("retime")
    if timed_pieces is None:
        timed_pieces = [
            _time_piece(smooth_piece, positive_limits, retimer, path_limits, deadline)
            for smooth_piece in smooth_pieces(spline, retimer.smoothness)
        ]
    return joined(spline, timed_pieces, retimer.rates, options)


def keep_timing(
    trajectory: TimedTrajectory,
    limits: JointLimits,
    options: RetimeOptions,
    path_limits: Sequence[PathLimit] = (),
    deadline: Deadline = NO_DEADLINE,
) -> tuple[TimedTrajectory, RetimeReport] | None:
    """Return a smooth motion with the time that it has, if it keeps all limits; else None.

    It is slowed where a limit is exceeded by no more than a solver's tolerance, or where a longer
    duration is requested.

    Args:
        trajectory: The motion, from rest to rest, smooth enough for the method.
        limits: As for `retime`, like the others.
        options: Method and factors.
        path_limits: Limits other than those of joints.
        deadline: Time limit.

    Raises:
        RetimingFailed: The requested duration is less than that of the motion.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    retimer = RETIMERS[options.method]
    scaled_limits = limits.scaled(options.velocity_scale, options.acceleration_scale)
    positive_limits = _positive_limits(trajectory, scaled_limits, options.method)
    piece = audited(trajectory, positive_limits, retimer.rates, path_limits, deadline, fastest=1.0)
    if piece.trajectory.duration > trajectory.duration * _KEPT_TIME_SCALING:
        return None
    return joined(trajectory, [piece], retimer.rates, options)


def _time_piece(
    smooth_piece: JointSpline,
    limits: JointLimits,
    retimer: Retimer,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> TimedPiece:
    """Return one smooth piece timed, audited and slowed by the factor of the audit."""
    deadline.check("retime")
    profile = retimer.profile(smooth_piece, limits, path_limits, deadline)
    deadline.check("retime")
    return audited(compose(smooth_piece, profile), limits, retimer.rates, path_limits, deadline)


def _positive_limits(spline: Curve, limits: JointLimits, method: str) -> JointLimits:
    """Return limits that are positive and finite for every block.

    Raises:
        RetimingFailed: A block that moves along the spline has a limit of zero.
    """
    rates = {name: np.asarray(getattr(limits, name)) for name in RATES}
    if all((values > 0).all() and (values <= _MAX_RATE).all() for values in rates.values()):
        return limits
    moving = [bool(spline.coefficients[:, 1:, list(block)].any()) for block in limits.blocks]
    names = block_names(spline)
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
