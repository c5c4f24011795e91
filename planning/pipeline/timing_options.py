"""What the options of the timing must satisfy to be meant in a world."""

from dataclasses import replace

import numpy as np

from planning.domain.request.motion_limits import SpeedZone, require_signs
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointGroup
from planning.errors import ProblemInvalid
from planning.world.mechanics.dynamics import validate_payload
from planning.world.world import Array, World


def validate_timing(
    world: World, group: JointGroup, options: RetimeOptions, start: Array, within: str = "retime."
) -> RetimeOptions:
    """Return the options with all zones in world: frames count where the start puts them.

    Args:
        world: The scene.
        group: What moves.
        options: As they were given.
        start: The group's q where the motion begins, shape (nq,).
        within: What stands before the options' names in the request, for messages.

    Raises:
        UnknownName: A frame or joint does not exist.
        ProblemInvalid: A number makes no sense, or a name comes twice.
    """
    _require_tool_limits(world, options, within)
    _require_zones(world, options.speed_zones, within)
    _require_bounds(group, options, within)
    if options.deviation is not None:
        is_length = 0 <= options.deviation < np.inf
        _demand(is_length, f"{within}deviation", "a length of at least 0 is needed")
    if options.payload is not None:
        validate_payload(world, group, options.payload, f"{within}payload")
    if not options.speed_zones:
        return options
    full = world.embed(group, start)
    placed = tuple(_placed(world, zone, full) for zone in options.speed_zones)
    return replace(options, speed_zones=placed)


def _placed(world: World, zone: SpeedZone, full: Array) -> SpeedZone:
    pose = world.frame_pose(zone.box.reference, full) @ zone.box.pose
    return replace(zone, box=replace(zone.box, pose=pose, reference="world"))


def _require_tool_limits(world: World, options: RetimeOptions, within: str) -> None:
    frames = [limit.frame for limit in options.tool_limits]
    for i, limit in enumerate(options.tool_limits):
        field = f"{within}tool_limits.{i}"
        world.require_frame(limit.frame)
        rates = [rate for rate in (limit.speed, limit.acceleration) if rate is not None]
        _demand(bool(rates), field, "a speed or an acceleration is needed")
        _demand(all(0 < rate < np.inf for rate in rates), field, "limits must be positive")
        _demand(frames.count(limit.frame) == 1, field, f"{limit.frame} is limited twice")


def _require_zones(world: World, zones: tuple[SpeedZone, ...], within: str) -> None:
    names = [zone.name for zone in zones]
    for i, zone in enumerate(zones):
        field = f"{within}speed_zones.{i}"
        world.require_frame(zone.frame)
        world.require_frame(zone.box.reference)
        _demand(0 < zone.speed < np.inf, field, "the speed must be positive")
        _demand(bool((zone.box.size > 0).all()), field, "every side must be longer than 0")
        _demand(names.count(zone.name) == 1, field, f"two zones are called {zone.name!r}")


def _require_bounds(group: JointGroup, options: RetimeOptions, within: str) -> None:
    require_signs(options.acceleration_bounds, group.joints)
    for name, (lowest, highest) in options.acceleration_bounds.items():
        is_apart = -np.inf < lowest < 0 < highest < np.inf
        field = f"{within}acceleration_bounds.{name}"
        _demand(is_apart, field, "the lowest must be negative, the highest positive")


def _demand(holds: bool, field: str, message: str) -> None:  # noqa: FBT001
    if not holds:
        raise ProblemInvalid(f"{field}: {message}", {"field": field})
