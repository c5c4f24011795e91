"""The loads and signed accelerations that limits besides those of joints make for the optimiser."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.joints import JointGroup, JointLimits
from planning.domain.manifold import Manifold
from planning.domain.motion_limits import AccelerationBounds, MotionLimits
from planning.refine.load import Load
from planning.refine.tool_load import ToolLoad
from planning.refine.torque_load import TorqueLoad
from planning.world.dynamics import GroupDynamics
from planning.world.tool_kinematics import ToolKinematics
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]


def loads_of(
    world: World, group: JointGroup, limits: JointLimits, others: MotionLimits
) -> tuple[Load, ...]:
    """Return the loads; none of a group with a joint that floats, whose coordinates are no v.

    Raises:
        UnknownName: A frame does not exist.
        ProblemInvalid: The group does not move the payload.
    """
    if not Manifold(group.joints).is_flat:
        return ()
    tools = (
        ToolLoad(ToolKinematics(world, group, limit.frame), limit) for limit in others.tool_limits
    )
    if not others.effort:
        return tuple(tools)
    return (TorqueLoad.of(GroupDynamics(world, group, others.payload), limits), *tools)


def signed_accelerations(
    group: JointGroup, bounds: AccelerationBounds
) -> Float64[np.ndarray, "2 nv"] | None:
    """Return the lowest and highest acceleration of every coordinate, infinite without; or None."""
    if not bounds:
        return None
    found = np.array([[-np.inf], [np.inf]]) * np.ones(group.num_velocities)
    columns = dict(group.blocks)
    for name, pair in bounds.items():
        found[:, columns[name][0]] = pair
    return found


def unsigned(signed: Float64[np.ndarray, "2 nv"]) -> Float64[np.ndarray, "2 nv"]:
    """Return the nearer of both bounds for both signs: all that retimers know that bound jerk."""
    nearer = np.abs(signed).min(axis=0)
    return np.stack([-nearer, nearer])
