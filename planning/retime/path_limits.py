"""The path limits of one group that the options of the timing ask for."""

from planning.domain.joints import JointGroup
from planning.domain.options import RetimeOptions
from planning.retime.path_limit import PathLimit
from planning.retime.tool_path import ToolPath
from planning.retime.tool_rate import ToolRate
from planning.retime.torque_limit import TorqueLimit
from planning.world.dynamics import GroupDynamics
from planning.world.tool_kinematics import ToolKinematics
from planning.world.world import World


def path_limits(world: World, group: JointGroup, options: RetimeOptions) -> tuple[PathLimit, ...]:
    """Return what limits motions of a group besides its joints.

    Raises:
        UnknownName: A frame does not exist.
        ProblemInvalid: The group does not move the payload.
    """
    found: list[PathLimit] = []
    if options.tool_limits:
        found += _tool_rates(world, group, options)
    if options.effort:
        dynamics = GroupDynamics(world, group, options.payload)
        found.append(TorqueLimit(group, dynamics, world.limits(group).effort))
    return tuple(found)


def _tool_rates(world: World, group: JointGroup, options: RetimeOptions) -> list[PathLimit]:
    frames = dict.fromkeys(limit.frame for limit in options.tool_limits)
    paths = {frame: ToolPath(ToolKinematics(world, group, frame)) for frame in frames}
    return [
        ToolRate(limit.frame, paths[limit.frame], order, rate)
        for limit in options.tool_limits
        for order, rate in ((1, limit.speed), (2, limit.acceleration))
        if rate is not None
    ]
