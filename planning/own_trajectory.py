"""certify_trajectory(): the certifier by itself, for a motion that somebody else made."""

from dataclasses import replace
from typing import Any

from planning.certify.certifier import certify
from planning.certify.first_unproven import with_first_unproven
from planning.domain.certificate import Certificate
from planning.domain.constraint import PathConstraint
from planning.domain.curve import TimedTrajectory
from planning.domain.deadline import Deadline
from planning.domain.joints import JointGroup
from planning.domain.options import CertifyOptions, RetimeOptions
from planning.domain.report import CertifyReport
from planning.errors import ProblemInvalid
from planning.proof_request import proof_request
from planning.timing import admit_timing
from planning.world.positions import require_positions
from planning.world.rules.admission import require_constraints
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
    wanted: CertifyOptions | None = None,
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
        wanted: What else to find out, if it is proven; None for nothing.

    Returns:
        The certificate, `proven` or with failed checks, and what it took. If clearance is not
        proven it says until when it is.

    Raises:
        UnknownName: There is no such group, body, frame or joint.
        ProblemInvalid: The trajectory is of other joints, start or goal do not fit the group, or
            a limit makes no sense.
        DeadlineExceeded: Time ran out before the verdict.
        Canceled: Somebody asked for the end.
    """
    joints = world.group(group)
    require_joints(joints, trajectory, "trajectory")
    begin, end = (
        reached if asked is None else require_positions(joints, asked, field)
        for asked, reached, field in (
            (start, trajectory.start, "start"),
            (goal, trajectory.end, "goal"),
        )
    )
    options, wanted = options or RetimeOptions(), wanted or CertifyOptions()
    require_constraints(world, joints, constraints)
    options = admit_timing(world, joints, options, begin, within="")
    request = replace(
        proof_request(world, joints, trajectory, options, world.margins(margin)),
        start=begin,
        goals=end[None],
        constraints=constraints,
        options=wanted,
    )
    certificate, report = certify(world.drake, request, deadline)
    return with_first_unproven(world.drake, request, certificate, deadline), report


def require_joints(group: JointGroup, trajectory: TimedTrajectory, field: str) -> None:
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
