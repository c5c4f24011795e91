"""What a motion is held against: everything that the options of its timing ask for."""

from planning.certify.request import CertifyRequest
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointGroup
from planning.world.collision.margins import PairMargins
from planning.world.world import World


def certify_request(
    world: World,
    group: JointGroup,
    trajectory: TimedTrajectory,
    options: RetimeOptions,
    margins: PairMargins,
) -> CertifyRequest:
    """Return the request to prove a motion from where it begins to where it ends.

    Who asks for more, or for other ends, replaces the rest.

    Args:
        world: The scene.
        group: What moves.
        trajectory: The motion.
        options: Limits besides the group's own, admitted by `admit_timing`; `method` says whether
            jerk is limited.
        margins: The distances to keep.
    """
    limits, followers = world.stated_limits(group)
    scales = options.velocity_scale, options.acceleration_scale
    return CertifyRequest(
        group=group,
        trajectory=trajectory,
        state=world.state,
        start=trajectory.start,
        goals=trajectory.end[None],
        limits=limits.scaled(*scales),
        followers=tuple(follower.scaled(*scales) for follower in followers),
        margins=margins,
        jerk=options.method == "ruckig",
        tool_limits=options.tool_limits,
        speed_zones=options.speed_zones,
        acceleration_bounds=options.acceleration_bounds,
        effort=options.effort,
        payload=options.payload,
    )
