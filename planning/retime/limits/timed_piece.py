"""TimedPiece: a timed smooth piece, scaled by the audit of its limits; and pieces as one motion."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import prod, sqrt

from planning.domain.curves.curve import Curve, TimedTrajectory
from planning.domain.report.stage_reports import RetimeReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointLimits
from planning.errors import RetimingFailed
from planning.retime.limit_utilization import LimitUtilization, max_utilization
from planning.retime.limits.path_limit import PathLimit, PathUtilization, path_limit_utilizations

# Relative reserve to every limit that the audit leaves.
_LIMIT_RESERVE = 1e-9


@dataclass(frozen=True)
class TimedPiece:
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


def audited(
    raw: TimedTrajectory,
    limits: JointLimits,
    rates: tuple[str, ...],
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
    *,
    fastest: float = 0.0,
) -> TimedPiece:
    """Return a timed piece scaled until it meets a limit, by no less than `fastest`."""
    utilizations = [max_utilization(raw, limits, order) for order in range(1, len(rates) + 1)]
    path_utilizations = path_limit_utilizations(path_limits, raw, deadline)
    time_scaling = max(
        # Powers differ from one machine to another, square roots do not.
        sqrt(use.fraction) if order == 2 else use.fraction ** (1 / order)
        for order, use in enumerate(utilizations, start=1)
    )
    time_scaling = max([time_scaling, *(use.time_scaling for _, use in path_utilizations)])
    time_scaling = max(time_scaling * (1 + _LIMIT_RESERVE), fastest)
    scaled = [
        replace(use, fraction=use.fraction / prod([time_scaling] * order))
        for order, use in enumerate(utilizations, start=1)
    ]
    slowed = [(name, use.slowed(time_scaling)) for name, use in path_utilizations]
    return TimedPiece(raw.time_scaled(time_scaling), scaled, slowed, raw.duration)


def joined(
    curve: Curve, timed_pieces: list[TimedPiece], rates: tuple[str, ...], options: RetimeOptions
) -> tuple[TimedTrajectory, RetimeReport]:
    """Return smooth pieces as one motion of the requested duration, and the report.

    Raises:
        RetimingFailed: The requested duration is less than the limits allow.
    """
    trajectory = TimedTrajectory.joined([part.trajectory for part in timed_pieces])
    time_scaling = _requested_time_scaling(trajectory.duration, options)
    names = block_names(curve)
    max_utilizations = [
        max((part.utilizations[i] for part in timed_pieces), key=lambda use: use.fraction)
        for i in range(len(rates))
    ]
    result = trajectory if time_scaling == 1.0 else trajectory.time_scaled(time_scaling)
    binding = {rate: names[use.block] for rate, use in zip(rates, max_utilizations, strict=True)}
    utilisation = {
        rate: use.fraction / time_scaling**order
        for order, (rate, use) in enumerate(zip(rates, max_utilizations, strict=True), start=1)
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


def block_names(curve: Curve) -> list[str]:
    """Return the names of a curve's blocks of coordinates."""
    return [name for joint in curve.joints for name, _ in joint.blocks]
