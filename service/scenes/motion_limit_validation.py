"""Preflight of limits on a motion: the frames and joints that they name are the scene's."""

from planning.domain.request.motion_limits import missing_effort_limits, validate_signed_blocks
from service.plans.models.motion_limits import MotionLimits
from service.scenes.records import SceneRecord
from service.scenes.validation import Group, joints_of, require_frames


def require_motion_limits(scene: SceneRecord, group: Group, limits: MotionLimits) -> None:
    """Go on only if the limits name what the scene has.

    Raises:
        UnknownName: A frame or joint does not exist, or has several coordinates.
        ProblemInvalid: Efforts shall be kept, and no joint of the group has a limit on them.
    """
    if limits.effort and all(bound is None for bound in group["limits"]["effort"]):
        raise missing_effort_limits(group["name"])
    require_frames(scene, [limit.frame for limit in limits.tool_limits])
    for zone in limits.speed_zones:
        require_frames(scene, [zone.frame, zone.box.pose.frame])
    if limits.payload is not None:
        require_frames(scene, [limits.payload.frame])
    validate_signed_blocks(limits.acceleration_bounds, joints_of(group))
