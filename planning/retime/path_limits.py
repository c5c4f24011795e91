"""The path limits of one group that the options of the timing ask for."""

from planning.domain.joints import JointGroup
from planning.domain.options import RetimeOptions
from planning.retime.path_limit import PathLimit
from planning.retime.tool_path import ToolPath
from planning.retime.tool_rate import ToolRate
from planning.world.tool_kinematics import ToolKinematics
from planning.world.world import World


def path_limits(world: World, group: JointGroup, options: RetimeOptions) -> tuple[PathLimit, ...]:
    """Return what limits motions of a group besides its joints.

    Raises:
        UnknownName: A frame does not exist.
    """
    if not options.tool_limits:
        return ()
    frames = dict.fromkeys(limit.frame for limit in options.tool_limits)
    paths = {frame: ToolPath(ToolKinematics(world, group, frame)) for frame in frames}
    return tuple(
        ToolRate(limit.frame, paths[limit.frame], order, rate)
        for limit in options.tool_limits
        for order, rate in ((1, limit.speed), (2, limit.acceleration))
        if rate is not None
    )
