"""MotionLimits: tool speed and acceleration limits, speed zones and signed acceleration bounds."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from planning.domain.request.constraint import PlacedBox
from planning.domain.robot.joints import Joint
from planning.domain.robot.payload import Payload
from planning.domain.value import Value
from planning.errors import ProblemInvalid, UnknownName

# Lowest and highest joint acceleration [rad/s^2 or m/s^2], by name.
type AccelerationBounds = Mapping[str, tuple[float, float]]


def validate_signed_blocks(names: Iterable[str], joints: Iterable[Joint]) -> None:
    """Raise unless every name of acceleration bounds is a joint block of one coordinate.

    Raises:
        UnknownName: A name is not; evidence lists the blocks that can be bounded, and those that
            cannot because they have several coordinates and so no sign.
    """
    names = tuple(names)
    if not names:
        return
    blocks = [block for joint in joints for block in joint.blocks]
    single_coordinate_blocks = [name for name, indices in blocks if len(indices) == 1]
    by_norm = [name for name, indices in blocks if len(indices) > 1]
    for name in names:
        if name not in single_coordinate_blocks:
            fault = UnknownName.among("joint", name, single_coordinate_blocks)
            hint = "".join(f"did you mean {near!r}? " for near in fault.evidence["nearest"][:1])
            message = (
                f"acceleration_bounds: {name!r} cannot be bounded; {hint}"
                f"joints with signed bounds: {single_coordinate_blocks}; "
                f"limited by a norm, which has no sign: {by_norm}"
            )
            raise UnknownName(message, {**fault.evidence, "by_norm": by_norm})


@dataclass(frozen=True, eq=False)
class ToolLimit(Value):
    """Cartesian limits on the origin of a frame.

    Attributes:
        frame: Full name, any frame of the scene.
        speed: Largest speed [m/s]; None for no limit.
        acceleration: Largest acceleration in any direction [m/s^2]; None for no limit.
    """

    frame: str
    speed: float | None = None
    acceleration: float | None = None


@dataclass(frozen=True, eq=False)
class SpeedZone(Value):
    """Box in which the origin of a frame has a lower speed limit.

    Attributes:
        name: Name in reports; no two zones share one.
        frame: Full name, any frame of the scene.
        box: The box.
        speed: Largest speed in the box [m/s].
    """

    name: str
    frame: str
    box: PlacedBox
    speed: float


@dataclass(frozen=True, eq=False)
class MotionLimits(Value):
    """Limits on a motion in addition to the joint limits: Cartesian, signed and effort limits.

    Attributes:
        tool_limits: Cartesian limits of frames.
        speed_zones: Boxes with lower speed limits, in world.
        acceleration_bounds: Signed acceleration bounds of joints.
        limits_effort: Whether the limits on joint torques and forces are kept.
        payload: Mass carried by the group that the scene does not contain; it counts for efforts.
    """

    tool_limits: tuple[ToolLimit, ...] = ()
    speed_zones: tuple[SpeedZone, ...] = ()
    acceleration_bounds: AccelerationBounds = field(default_factory=dict)
    limits_effort: bool = False
    payload: Payload | None = None


def missing_effort_limits(group: str) -> ProblemInvalid:
    """Return the error for a request to keep the effort limits of a group that has none."""
    message = f"effort: no joint of {group!r} has a force or torque limit; state one (URDF's "
    message += "`effort`, or `limits` in robot.yaml), or leave `effort` out of the request"
    return ProblemInvalid(message, {"field": "effort", "group": group})
