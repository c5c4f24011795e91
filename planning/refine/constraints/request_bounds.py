"""request_bounds(): bounds of a request for the trajectory optimisation: joint rates and loads."""

import numpy as np
from jaxtyping import Float64

from planning.domain.request.motion_limits import AccelerationBounds
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.refine.constraints.load import Load
from planning.refine.constraints.rate_bounds import RateBounds
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
    signed = signed_accelerations(request.path.group, request.others.acceleration_bounds)
    if signed is not None and request.jerk:
        # Retimers with jerk bounds have one acceleration bound for both signs.
        signed = np.abs(signed).min(axis=0) * np.array([[-1.0], [1.0]])
    loads = _loads(world, request)
    return RateBounds.of(request.limits, jerk=request.jerk, signed=signed, loads=loads)


def signed_accelerations(
    group: JointGroup, bounds: AccelerationBounds
) -> Float64[np.ndarray, "2 nv"] | None:
    """Return lowest and highest accelerations by coordinate, infinite if unbounded, or None."""
    if not bounds:
        return None
    found = np.array([[-np.inf], [np.inf]]) * np.ones(group.num_velocities)
    columns = dict(group.blocks)
    for name, pair in bounds.items():
        found[:, columns[name][0]] = pair
    return found


def _loads(world: World, request: RefineRequest) -> tuple[Load, ...]:
    """Return the loads; none for groups with a floating joint, where rates of q are not v."""
    group, others = request.path.group, request.others
    if not Manifold(group.joints).is_flat:
        return ()
    tools = tuple(
        ToolLoad(ToolKinematics(world, group, limit.frame), limit) for limit in others.tool_limits
    )
    zones = tuple(ZoneLoad.of(world, group, zone) for zone in others.speed_zones)
    if not others.effort:
        return *tools, *zones
    efforts = TorqueLoad.of(GroupDynamics(world, group, others.payload), request.limits)
    return efforts, *tools, *zones
