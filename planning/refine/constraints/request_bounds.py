"""request_bounds(): bounds of a request for the trajectory optimization: joint rates and loads."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from planning.domain.request.motion_limits import AccelerationBounds
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.refine.constraints.load import Load
from planning.refine.constraints.rate_bounds import UNBOUNDED_JERK, RateBounds
from planning.refine.constraints.tool_load import ToolLoad
from planning.refine.constraints.torque_load import TorqueLoad
from planning.refine.constraints.zone_load import ZoneLoad
from planning.refine.request import RefineRequest
from planning.world.mechanics.dynamics import GroupDynamics
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World


def request_bounds(world: World, request: RefineRequest) -> RateBounds:
    """Return the bounds of a request on joint rates and loads.

    Raises:
        UnknownName: A frame does not exist.
        ProblemInvalid: The group does not move the payload.
    """
    acceleration_bounds = signed_accelerations(
        request.path.group, request.motion_limits.acceleration_bounds
    )
    if acceleration_bounds is not None and request.limits_jerk:
        # Retimers with jerk bounds have one acceleration bound for both signs.
        acceleration_bounds = np.abs(acceleration_bounds).min(axis=0) * np.array([[-1.0], [1.0]])
    loads = _loads(world, request)
    return RateBounds.of(
        request.limits,
        limits_jerk=request.limits_jerk,
        acceleration_bounds=acceleration_bounds,
        loads=loads,
    )


def exact_rate_bounds(request: RefineRequest, loads: tuple[Load, ...]) -> RateBounds:
    """Return the bounds that are proven in the end, without allowance for a retimer with jerk.

    `request_bounds` lowers accelerations where jerk is limited, because its duration is that of a
    model without jerk.
    """
    limits = request.limits
    accelerations = signed_accelerations(
        request.path.group, request.motion_limits.acceleration_bounds
    )
    bounds = RateBounds.of(
        limits, limits_jerk=False, acceleration_bounds=accelerations, loads=loads
    )
    if not request.limits_jerk:
        return bounds
    jerk = np.minimum(limits.per_coordinate(limits.jerk), UNBOUNDED_JERK)
    return replace(bounds, jerk=jerk)


def signed_accelerations(
    group: JointGroup, bounds: AccelerationBounds
) -> Float64[np.ndarray, "2 nv"] | None:
    """Return lowest and highest accelerations by coordinate, infinite if unbounded, or None."""
    if not bounds:
        return None
    accelerations = np.array([[-np.inf], [np.inf]]) * np.ones(group.num_velocities)
    columns = dict(group.blocks)
    for name, pair in bounds.items():
        accelerations[:, columns[name][0]] = pair
    return accelerations


def _loads(world: World, request: RefineRequest) -> tuple[Load, ...]:
    """Return the loads; none for groups with a floating joint, where rates of q are not v."""
    group, motion_limits = request.path.group, request.motion_limits
    if not Manifold(group.joints).is_flat:
        return ()
    tools = tuple(
        ToolLoad(ToolKinematics(world, group, limit.frame), limit)
        for limit in motion_limits.tool_limits
    )
    zones = tuple(ZoneLoad.of(world, group, zone) for zone in motion_limits.speed_zones)
    if not motion_limits.limits_effort:
        return *tools, *zones
    efforts = TorqueLoad.of(GroupDynamics(world, group, motion_limits.payload), request.limits)
    return efforts, *tools, *zones
