"""Request limits: the path limits of a group from the timing options of a request."""

import numpy as np

from planning.domain.request.motion_limits import missing_effort_limits
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointGroup
from planning.retime.limits.path_limit import PathLimit
from planning.retime.limits.signed_acceleration import SignedAcceleration
from planning.retime.limits.tool_path import ToolPath
from planning.retime.limits.tool_rate import ToolRate
from planning.retime.limits.torque_limit import TorqueLimit
from planning.retime.limits.zone_speed import ZoneSpeed
from planning.world.mechanics.dynamics import GroupDynamics
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World


def path_limits(world: World, group: JointGroup, options: RetimeOptions) -> tuple[PathLimit, ...]:
    """Return the path limits on motions of a group; zones are in world.

    Raises:
        UnknownName: A frame does not exist.
        ProblemInvalid: The group does not move the payload, or no joint of it has a limit on
            effort that could be kept.
    """
    return (
        *_acceleration_limits(group, options),
        *_torque_limits(world, group, options),
        *_frame_limits(world, group, options),
    )


def _acceleration_limits(
    group: JointGroup, options: RetimeOptions
) -> tuple[SignedAcceleration, ...]:
    if not options.acceleration_bounds:
        return ()
    columns = dict(group.blocks)
    chosen = tuple(columns[name][0] for name in options.acceleration_bounds)
    return (SignedAcceleration(options.acceleration_bounds, chosen),)


def _torque_limits(
    world: World, group: JointGroup, options: RetimeOptions
) -> tuple[TorqueLimit, ...]:
    if not options.effort:
        return ()
    efforts = world.limits(group).effort
    if not np.isfinite(efforts).any():
        raise missing_effort_limits(group.name)
    return (TorqueLimit(group, GroupDynamics(world, group, options.payload), efforts),)


def _frame_limits(
    world: World, group: JointGroup, options: RetimeOptions
) -> tuple[ToolRate | ZoneSpeed, ...]:
    frames = [entry.frame for entry in (*options.tool_limits, *options.speed_zones)]
    if not frames:
        return ()
    paths = {
        frame: ToolPath(ToolKinematics(world, group, frame)) for frame in dict.fromkeys(frames)
    }
    rates = [
        ToolRate(limit.frame, paths[limit.frame], order, rate)
        for limit in options.tool_limits
        for order, rate in ((1, limit.speed), (2, limit.acceleration))
        if rate is not None
    ]
    zones = [ZoneSpeed(zone, paths[zone.frame], zone.speed) for zone in options.speed_zones]
    return (*rates, *zones)
