"""Resolution of retiming options: checks against a world, and speed zones placed in world."""

from dataclasses import replace

import numpy as np

from planning.domain.arrays import Array
from planning.domain.request.motion_limits import SpeedZone, validate_signed_blocks
from planning.domain.request.options import MIN_SCALE, RetimeOptions
from planning.domain.robot.joints import JointGroup
from planning.errors import ProblemInvalid
from planning.world.mechanics.dynamics import validate_payload
from planning.world.world import World


def resolve_retiming(
    world: World,
    group: JointGroup,
    options: RetimeOptions,
    start: Array,
    field_prefix: str = "retime.",
) -> RetimeOptions:
    """Return the options with all speed zones in world, moving frames evaluated at the start.

    Args:
        world: Loaded scene.
        group: Joint group that moves.
        options: Given options.
        start: The group's q at the beginning of the motion, shape (nq,).
        field_prefix: Prefix of the options' names in the request, for messages.

    Raises:
        UnknownName: A frame or joint does not exist.
        ProblemInvalid: A number is invalid, or a name occurs twice.
    """
    for name in ("velocity_scale", "acceleration_scale"):
        is_scale = MIN_SCALE <= getattr(options, name) <= 1
        _validate(is_scale, f"{field_prefix}{name}", f"it must be in [{MIN_SCALE:g}, 1]")
    _validate_tool_limits(world, options, field_prefix)
    _validate_zones(world, options.speed_zones, field_prefix)
    _validate_bounds(group, options, field_prefix)
    if options.deviation is not None:
        is_length = 0 <= options.deviation < np.inf
        _validate(is_length, f"{field_prefix}deviation", "it must be finite and not negative")
    if options.payload is not None:
        validate_payload(world, group, options.payload, f"{field_prefix}payload")
    if not options.speed_zones:
        return options
    full = world.embed(group, start)
    zones_in_world = tuple(_zone_in_world(world, zone, full) for zone in options.speed_zones)
    return replace(options, speed_zones=zones_in_world)


def _zone_in_world(world: World, zone: SpeedZone, full: Array) -> SpeedZone:
    pose = world.frame_pose(zone.box.reference, full) @ zone.box.pose
    return replace(zone, box=replace(zone.box, pose=pose, reference="world"))


def _validate_tool_limits(world: World, options: RetimeOptions, field_prefix: str) -> None:
    frames = [limit.frame for limit in options.tool_limits]
    for i, limit in enumerate(options.tool_limits):
        field = f"{field_prefix}tool_limits.{i}"
        world.validate_frame(limit.frame)
        rates = [rate for rate in (limit.speed, limit.acceleration) if rate is not None]
        _validate(bool(rates), field, "a speed or an acceleration is needed")
        _validate(all(0 < rate < np.inf for rate in rates), field, "limits must be positive")
        _validate(frames.count(limit.frame) == 1, field, f"{limit.frame} is limited twice")


def _validate_zones(world: World, zones: tuple[SpeedZone, ...], field_prefix: str) -> None:
    names = [zone.name for zone in zones]
    for i, zone in enumerate(zones):
        field = f"{field_prefix}speed_zones.{i}"
        world.validate_frame(zone.frame)
        world.validate_frame(zone.box.reference)
        _validate(0 < zone.speed < np.inf, field, "the speed must be positive")
        _validate(bool((zone.box.size > 0).all()), field, "every side of the box must be positive")
        _validate(names.count(zone.name) == 1, field, f"two zones are called {zone.name!r}")


def _validate_bounds(group: JointGroup, options: RetimeOptions, field_prefix: str) -> None:
    validate_signed_blocks(options.acceleration_bounds, group.joints)
    for name, (lowest, highest) in options.acceleration_bounds.items():
        has_both_signs = -np.inf < lowest < 0 < highest < np.inf
        field = f"{field_prefix}acceleration_bounds.{name}"
        _validate(
            has_both_signs,
            field,
            "the lowest acceleration must be negative, the highest positive, both finite",
        )


def _validate(is_valid: bool, field: str, message: str) -> None:  # noqa: FBT001
    if not is_valid:
        raise ProblemInvalid(f"{field}: {message}", {"field": field})
