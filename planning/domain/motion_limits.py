"""Limits on a motion besides those of single joints: of frames, in boxes, by sign."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from planning.domain.constraint import PlacedBox
from planning.domain.payload import Payload
from planning.domain.value import Value

# Lowest and highest acceleration of joints [rad/s^2 or m/s^2], by name.
type AccelerationBounds = Mapping[str, tuple[float, float]]


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
    """Those of these limits that hold all along a motion, wherever it leads.

    Attributes:
        tool_limits: Of frames.
        acceleration_bounds: Of joints.
        effort: Whether the limits on joint torques and forces are kept.
        payload: What the group carries that the scene does not show; it counts for efforts.
    """

    tool_limits: tuple[ToolLimit, ...] = ()
    acceleration_bounds: AccelerationBounds = field(default_factory=dict)
    effort: bool = False
    payload: Payload | None = None
