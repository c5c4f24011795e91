"""certify_trajectory(): certification of a given trajectory."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from planning.certify.certifier import certify, certify_polyline, skipped_checks
from planning.certify.clearance.first_unproven import with_first_unproven
from planning.certify.request import CertifyRequest
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Certificate
from planning.domain.report.stage_reports import CertifyReport
from planning.domain.request.constraint import PathConstraint
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import CertifyOptions, RetimeOptions
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup
from planning.errors import ProblemInvalid
from planning.pipeline.certification import certify_request
from planning.pipeline.timing.timing_options import resolve_retiming
from planning.world.constraints.validate_constraints import validate_constraints
from planning.world.loading.positions import validate_positions
from planning.world.world import World


def certify_trajectory(  # noqa: PLR0913  (all inputs of a request)
    world: World,
    group: str,
    trajectory: TimedTrajectory,
    *,
    deadline: Deadline,
    options: RetimeOptions | None = None,
    start: Any = None,
    goal: Any = None,
    margin: float | None = None,
    constraints: tuple[PathConstraint, ...] = (),
    certify_options: CertifyOptions | None = None,
) -> tuple[Certificate, CertifyReport]:
    """Certify a trajectory: limits, ends, margins and constraints, on its whole interval.

    Args:
        world: Loaded scene.
        group: Joint group that moves, `robot` or `robot::group`.
        trajectory: The exact motion.
        deadline: Time limit.
        options: Scales that multiply the limits, and limits of frames, zones and accelerations;
            jerk is limited if `method` is "ruckig". None for the defaults.
        start: Required first configuration, shape (nq,); None for the trajectory's own.
        goal: Required last configuration, shape (nq,); None for the trajectory's own.
        margin: Required distance of bodies [m]; None for the scene's.
        constraints: Path constraints; those relative to the start refer to `start`.
        certify_options: Additional findings, if the motion is proven; None for none.

    Returns:
        The certificate, `proven` or with failed checks, and the certifier's report. If clearance is
        not proven, the certificate says until which instant it is.

    Raises:
        UnknownName: There is no such group, body, frame or joint.
        ProblemInvalid: The trajectory is of other joints, start or goal do not fit the group, or
            a limit is invalid.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
    """
    request = _make_request(world, group, trajectory, options, (start, goal), margin, constraints)
    request = replace(request, options=certify_options or CertifyOptions())
    with _timing_failures(deadline):
        certificate, report = certify(world.drake, request, deadline)
        return with_first_unproven(world.drake, request, certificate, deadline), report


def certify_positions(  # noqa: PLR0913  (all inputs of a request)
    world: World,
    group: str,
    trajectory: TimedTrajectory,
    *,
    deadline: Deadline,
    options: RetimeOptions | None = None,
    start: Any = None,
    goal: Any = None,
    margin: float | None = None,
    constraints: tuple[PathConstraint, ...] = (),
) -> tuple[Certificate, CertifyReport, tuple[str, ...]]:
    """Certify a polyline in joint space (`polyline_through`): all checks that apply to corners.

    These are ends, positions, speeds, constraints, speed limits of frames, and margins: the motion
    of a controller that receives positions only. Not promised: anything about accelerations.

    Args:
        world: Loaded scene.
        group: Joint group that moves, `robot` or `robot::group`.
        trajectory: The exact motion.
        deadline: Time limit.
        options: Scales that multiply the limits, and limits of frames and zones; None for the
            defaults.
        start: Required first configuration, shape (nq,); None for the trajectory's own.
        goal: Required last configuration, shape (nq,); None for the trajectory's own.
        margin: Required distance of bodies [m]; None for the scene's.
        constraints: Path constraints; those relative to the start refer to `start`.

    Returns:
        The result of `certify_trajectory`, and the names of the skipped checks.

    Raises:
        UnknownName: There is no such group, body, frame or joint.
        ProblemInvalid: The trajectory is of other joints, start or goal do not fit the group, or
            a limit is invalid.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
    """
    request = _make_request(world, group, trajectory, options, (start, goal), margin, constraints)
    with _timing_failures(deadline):
        certificate, report = certify_polyline(world.drake, request, deadline)
        located = with_first_unproven(world.drake, request, certificate, deadline)
        return located, report, skipped_checks(request)


@contextmanager
def _timing_failures(deadline: Deadline) -> Generator[None]:
    """Attach the time of the certification to failures that are raised inside the block."""
    watch = Stopwatch(deadline.clock)
    with watch.timing_failures(), watch.stage("certify"):
        yield


def _make_request(  # noqa: PLR0913, PLR0917  (all inputs of a request)
    world: World,
    group: str,
    trajectory: TimedTrajectory,
    options: RetimeOptions | None,
    ends: tuple[Any, Any],
    margin: float | None,
    constraints: tuple[PathConstraint, ...],
) -> CertifyRequest:
    """Return the certify request of a trajectory, after checks of its input."""
    joints = world.group(group)
    validate_joints(joints, trajectory, "trajectory")
    begin, end = (
        actual if requested is None else validate_positions(joints, requested, field)
        for requested, actual, field in zip(
            ends, (trajectory.start, trajectory.end), ("start", "goal"), strict=True
        )
    )
    validate_constraints(world, joints, constraints)
    options = resolve_retiming(world, joints, options or RetimeOptions(), begin, field_prefix="")
    return replace(
        certify_request(world, joints, trajectory, options, world.margins(margin)),
        start=begin,
        goals=end[None],
        constraints=constraints,
    )


def validate_joints(group: JointGroup, trajectory: TimedTrajectory, field: str) -> None:
    """Check that a trajectory has the joints of a group.

    Args:
        group: Joint group.
        trajectory: The trajectory.
        field: Name of the trajectory in the request, for the message.

    Raises:
        ProblemInvalid: The trajectory has other joints, or another order.
    """
    if trajectory.joints != group.joints:
        names = [joint.name for joint in group.joints]
        message = f"the {field} must have the joints {names}, in this order"
        raise ProblemInvalid(message, {"field": field, "expected": names})


def validate_motion(group: JointGroup, motion: TimedTrajectory, field: str) -> None:
    """Check that a motion has a group's joints and finite numbers, and that its times increase.

    Args:
        group: Joint group.
        motion: The motion.
        field: Name of the motion in the request, for the message.

    Raises:
        ProblemInvalid: The motion has other joints, or its numbers are none of a motion.
    """
    validate_joints(group, motion, field)
    numbers = (motion.breaks, motion.bases, motion.coefficients)
    is_timed = motion.breaks[0] == 0 and bool((np.diff(motion.breaks) > 0).all())
    if not (is_timed and all(np.isfinite(array).all() for array in numbers)):
        message = f"{field}: all numbers must be finite; its times must start at 0 and increase"
        raise ProblemInvalid(message, {"field": field})
