"""certify_trajectory(): the certifier by itself, for a motion that was made elsewhere."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

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
from planning.pipeline.timing_options import resolve_retiming
from planning.world.constraints.validate_constraints import validate_constraints
from planning.world.loading.positions import validate_positions
from planning.world.world import World


def certify_trajectory(  # noqa: PLR0913  (a question in full)
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
    """Hold a trajectory against limits, ends and margins, on its whole interval.

    Args:
        world: The scene, loaded.
        group: What moves.
        trajectory: The motion, exactly.
        deadline: When to stop.
        options: `method` says whether jerk is limited ("ruckig") or not; the scales multiply the
            limits; its limits of frames, zones and accelerations are checked as well.
        start: Where it shall begin, shape (nq,); None for where it does.
        goal: Where it shall end, shape (nq,); None for where it does.
        margin: Distance to keep [m]; None for the scene's.
        constraints: What it shall keep; what counts from the start counts from `start`.
        certify_options: What else to find out, if it is proven; None for nothing.

    Returns:
        The certificate, `proven` or with failed checks, and what it took. If clearance is not
        proven it says until when it is.

    Raises:
        UnknownName: There is no such group, body, frame or joint.
        ProblemInvalid: The trajectory is of other joints, start or goal do not fit the group, or
            a limit makes no sense.
        DeadlineExceeded: Time ran out before the verdict.
        Canceled: The end was asked for.
    """
    request = _make_request(world, group, trajectory, options, (start, goal), margin, constraints)
    request = replace(request, options=certify_options or CertifyOptions())
    with _timing_failures(deadline):
        certificate, report = certify(world.drake, request, deadline)
        return with_first_unproven(world.drake, request, certificate, deadline), report


def certify_positions(  # noqa: PLR0913  (a question in full)
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
    """Hold straight lines with corners (`polyline_through`) against all that corners can keep.

    That is ends, positions, speeds, constraints, limits on the speeds of frames, and margins: what
    a receiver of positions alone makes of them. Not promised: anything about accelerations.

    Args:
        world: The scene, loaded.
        group: What moves.
        trajectory: The motion, exactly.
        deadline: When to stop.
        options: The scales multiply the limits; its limits of frames and zones are checked.
        start: Where it shall begin, shape (nq,); None for where it does.
        goal: Where it shall end, shape (nq,); None for where it does.
        margin: Distance to keep [m]; None for the scene's.
        constraints: What it shall keep; what counts from the start counts from `start`.

    Returns:
        What `certify_trajectory` does, and the names of the checks that were left out.

    Raises:
        UnknownName: There is no such group, body, frame or joint.
        ProblemInvalid: The trajectory is of other joints, start or goal do not fit the group, or
            a limit makes no sense.
        DeadlineExceeded: Time ran out before the verdict.
        Canceled: The end was asked for.
    """
    request = _make_request(world, group, trajectory, options, (start, goal), margin, constraints)
    with _timing_failures(deadline):
        certificate, report = certify_polyline(world.drake, request, deadline)
        located = with_first_unproven(world.drake, request, certificate, deadline)
        return located, report, skipped_checks(request)


@contextmanager
def _timing_failures(deadline: Deadline) -> Generator[None]:
    """Have failures from inside tell how long the proof took."""
    watch = Stopwatch(deadline.clock)
    with watch.timing_failures(), watch.stage("certify"):
        yield


def _make_request(  # noqa: PLR0913, PLR0917  (a question in full)
    world: World,
    group: str,
    trajectory: TimedTrajectory,
    options: RetimeOptions | None,
    ends: tuple[Any, Any],
    margin: float | None,
    constraints: tuple[PathConstraint, ...],
) -> CertifyRequest:
    """Return what to prove, once it makes sense."""
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
    """Go on only if a trajectory is one of a group's joints.

    Args:
        group: What shall move.
        trajectory: How.
        field: What the caller calls the trajectory.

    Raises:
        ProblemInvalid: It is not.
    """
    if trajectory.joints != group.joints:
        names = [joint.name for joint in group.joints]
        message = f"the {field} is not one of the joints {names}, in this order"
        raise ProblemInvalid(message, {"field": field, "expected": names})
