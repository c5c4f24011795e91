"""approach_bound(): how much nearer bodies may be while joints are off their motion."""

import numpy as np
from jaxtyping import Float64

from planning.api.certify_trajectory import validate_joints
from planning.certify.clearance.lever_arms import lever_arms_of
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.request.options import RetimeOptions
from planning.pipeline.certification import certify_request
from planning.pipeline.timing.timing_options import resolve_retiming
from planning.world.world import World


def approach_bound(
    world: World,
    group: str,
    trajectory: TimedTrajectory,
    deviations: Float64[np.ndarray, " nv"],
) -> float:
    """Return a bound on the approach of two bodies [m] whatever the configuration.

    A motion with a certified clearance above it stays free of collisions where every joint is off
    by at most its deviation.

    Args:
        world: Loaded scene.
        group: Joint group that moves, `robot` or `robot::group`.
        trajectory: Its motion.
        deviations: Largest distance of each velocity coordinate from the motion [rad or m].

    Raises:
        UnknownName: There is no such group.
        ProblemInvalid: The trajectory is of other joints.
    """
    joints = world.group(group)
    validate_joints(joints, trajectory, "trajectory")
    start = trajectory.start
    timing = resolve_retiming(world, joints, RetimeOptions(), start, field_prefix="")
    request = certify_request(world, joints, trajectory, timing, world.margins(None))
    arms = lever_arms_of(world.drake, request)
    off = deviations > 0  # no deviation times an infinite arm is none
    return float(arms[off] @ deviations[off])
