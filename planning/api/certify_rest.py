"""certify_rest(): proof that what is left of a motion keeps its margins in another world."""

import numpy as np

from planning.api.certify_trajectory import validate_motion
from planning.certify.clearance.proof_in_order import prove_in_order
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.rest_report import RestReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RetimeOptions
from planning.errors import ProblemInvalid
from planning.pipeline.certification import certify_request
from planning.world.world import World


def certify_rest(
    world: World,
    group: str,
    trajectory: TimedTrajectory,
    since: float,
    *,
    deadline: Deadline,
    margin: float | None = None,
) -> RestReport:
    """Prove that a motion keeps its margins from an instant on, or tell until when it does.

    For an execution that is on its way while its scene changes. Segments are bounded in order of
    time, so that the answer is about the first conflict; no distance is refined, which makes it
    quicker than `certify_trajectory`. Its verdict on clearance is the same.

    Not proven here: limits, ends and constraints, which a change of obstacles does not touch; and
    anything about other robots that move (`certify_beside`): they rest where the world has them.

    Args:
        world: Loaded scene, as it is now, with what is attached.
        group: Joint group that moves, `robot` or `robot::group`.
        trajectory: The exact motion, all of it.
        since: Instant from which on it is proven [s].
        deadline: Time limit.
        margin: Required distance of bodies [m]; None for the scene's.

    Raises:
        UnknownName: There is no such group.
        ProblemInvalid: The trajectory is of other joints or malformed, or `since` is not within it.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
        ModelInvalid: The scene has a shape or joint of a kind that cannot be certified.
    """
    joints = world.group(group)
    validate_motion(joints, trajectory, "trajectory")
    if not (np.isfinite(since) and 0 <= since <= trajectory.duration):
        bounds = [0.0, trajectory.duration]
        message = f"since: {since:g} s is not within the motion, from 0 to {bounds[1]:.9g} s"
        raise ProblemInvalid(message, {"field": "since", "bounds": bounds, "got": since})
    rest = trajectory.after(since)
    request = certify_request(world, joints, rest, RetimeOptions(), world.margins(margin))
    deadline.check("certify")
    found = prove_in_order(world.drake, request, deadline)
    return RestReport(
        proven=found.proven,
        since=since,
        proven_until=trajectory.duration if found.proven else since + found.until,
        pair=found.bodies,
        distance=found.distance,
    )
