"""Limits on a motion besides those of its joints: from the wire to the domain."""

from typing import TypedDict

from planning.domain.request.motion_limits import AccelerationBounds, SpeedZone, ToolLimit
from planning.domain.robot.payload import Payload
from service.plans.models.constraint_values import box_value
from service.plans.models.motion_limits import ScaledLimits


class Limits(TypedDict):
    """Fields of the domain's `RetimeOptions`."""

    velocity_scale: float
    acceleration_scale: float
    tool_limits: tuple[ToolLimit, ...]
    speed_zones: tuple[SpeedZone, ...]
    acceleration_bounds: AccelerationBounds
    effort: bool
    payload: Payload | None


def motion_limits(wire: ScaledLimits) -> Limits:
    """Return the limits, and the scales, as fields of the options of the timing."""
    return Limits(
        velocity_scale=wire.velocity_scale,
        acceleration_scale=wire.acceleration_scale,
        tool_limits=tuple(
            ToolLimit(limit.frame, limit.speed, limit.acceleration) for limit in wire.tool_limits
        ),
        speed_zones=tuple(
            SpeedZone(zone.name, zone.frame, box_value(zone.box.size, zone.box.pose), zone.speed)
            for zone in wire.speed_zones
        ),
        acceleration_bounds={
            name: (low, high) for name, (low, high) in wire.acceleration_bounds.items()
        },
        effort=wire.effort,
        payload=None if wire.payload is None else wire.payload.value(),
    )
