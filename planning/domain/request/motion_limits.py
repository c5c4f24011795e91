"""Limits on a motion besides those of single joints: of frames, in boxes, by sign."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from planning.domain.request.constraint import PlacedBox
from planning.domain.robot.joints import Joint
from planning.domain.robot.payload import Payload
from planning.domain.value import Value
from planning.errors import ProblemInvalid, UnknownName

# Lowest and highest acceleration of joints [rad/s^2 or m/s^2], by name.
type AccelerationBounds = Mapping[str, tuple[float, float]]


def require_signs(names: Iterable[str], joints: Iterable[Joint]) -> None:
    """Go on only if names of acceleration bounds are of blocks of one coordinate.

    Raises:
        UnknownName: One is not; what can be bounded is told, and what cannot because it has no
            sign.
    """
    blocks = [block for joint in joints for block in joint.blocks]
    single = [name for name, indices in blocks if len(indices) == 1]
    by_norm = [name for name, indices in blocks if len(indices) > 1]
    for name in names:
        if name not in single:
            fault = UnknownName.among("joint", name, single)
            hint = "".join(f"did you mean {near!r}? " for near in fault.evidence["nearest"][:1])
            message = (
                f"acceleration_bounds: {name!r} cannot be bounded; {hint}what can: {single}; "
                f"what cannot, as it is limited by a norm, which has no sign: {by_norm}"
            )
            raise UnknownName(message, {**fault.evidence, "by_norm": by_norm})


@dataclass(frozen=True, eq=False)
class ToolLimit(Value):
    """How fast the origin of a frame may move.

    Attributes:
        frame: Full name, any frame of the scene.
        speed: At most [m/s]; None for any.
        acceleration: At most [m/s^2], in any direction; None for any.
    """

    frame: str
    speed: float | None = None
    acceleration: float | None = None


@dataclass(frozen=True, eq=False)
class SpeedZone(Value):
    """How fast the origin of a frame may move while it is in a box.

    Attributes:
        name: For reports; no two zones share one.
        frame: Full name, any frame of the scene.
        box: Where.
        speed: At most [m/s].
    """

    name: str
    frame: str
    box: PlacedBox
    speed: float


@dataclass(frozen=True, eq=False)
class MotionLimits(Value):
    """All these limits, and those of torques.

    Attributes:
        tool_limits: Of frames.
        speed_zones: In boxes, in world.
        acceleration_bounds: Of joints.
        effort: Whether the limits on joint torques and forces are kept.
        payload: What the group carries that the scene does not show; it counts for efforts.
    """

    tool_limits: tuple[ToolLimit, ...] = ()
    speed_zones: tuple[SpeedZone, ...] = ()
    acceleration_bounds: AccelerationBounds = field(default_factory=dict)
    effort: bool = False
    payload: Payload | None = None


def no_efforts(group: str) -> ProblemInvalid:
    """Return the error for a group whose efforts shall be kept, and nothing limits them."""
    message = f"effort: no joint of {group!r} has a limit on its force or torque that could be "
    message += "kept; state one (URDF's `effort`, or `limits` in robot.yaml), or leave it out"
    return ProblemInvalid(message, {"field": "effort", "group": group})
