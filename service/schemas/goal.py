"""Goals on the wire: what a motion shall reach."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

from service.schemas.numbers import NonNegative, Positions, Real, Triple
from service.schemas.pose import PoseWire
from service.schemas.wire import Name, Wire

_LATER = {
    "region": "use a `pose` goal with `tolerance`, where pi or more frees a rotation axis",
    "relative": "give the absolute `pose`, in any `frame`",
}


def not_supported(what: str, instead: str) -> PydanticCustomError:
    """Build the fault for a part of the contract that this version does not do."""
    return PydanticCustomError(
        "not_supported",
        "{what} is not supported by this version; {instead}",
        {"what": what, "instead": instead},
    )


def _known_type(goal: Any) -> Any:
    kind: Any = goal.get("type") if isinstance(goal, dict) else None
    if isinstance(kind, str) and kind in _LATER:
        raise not_supported(f"goal type {kind!r}", _LATER[kind])
    return goal


type Shift = Annotated[Real, Field(ge=1e-6, le=1)]
type Turn = Annotated[Real, Field(ge=1e-5, le=3)]


class DeviationWire(Wire):
    """How far a tool may be from its line, between waypoints and samples too."""

    position: Shift = Field(default=0.001, description="Of its origin, from the line [m]")
    rotation: Turn = Field(default=0.008726646259971648, description="Of its rotation [rad]")


class ToleranceWire(Wire):
    """How far from a target the tool frame may end, in the target's own axes."""

    position: Annotated[list[NonNegative], Field(min_length=3, max_length=3)] = Field(
        default=[0.0, 0.0, 0.0], description="Half-widths of a box about the target [m]"
    )
    rotation: Annotated[list[NonNegative], Field(min_length=3, max_length=3)] = Field(
        default=[0.0, 0.0, 0.0],
        description="Largest rotation about each axis [rad]; pi or more leaves the axis free",
    )


class JointGoalWire(Wire):
    """Reach a configuration, or any of several."""

    type: Literal["joint"] = Field(description="Says which goal this is")
    positions: Positions | Annotated[list[Positions], Field(min_length=1, max_length=1000)] = Field(
        description="The group's positions, one list or several [rad or m]"
    )


class ConfigurationGoalWire(Wire):
    """Reach a configuration that the scene or the robot names."""

    type: Literal["configuration"] = Field(description="Says which goal this is")
    name: Name = Field(description="Of the configuration, for example `home`")


class PoseGoalWire(Wire):
    """Bring a tool frame to a pose, or to any of several."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "type": "pose",
                    "poses": [{"position": [0, 0, 0], "frame": "pick"}],
                    "tolerance": {"position": [0, 0, 0], "rotation": [0, 0, 3.15]},
                }
            ]
        }
    )

    type: Literal["pose"] = Field(description="Says which goal this is")
    poses: Annotated[list[PoseWire], Field(min_length=1, max_length=1000)] = Field(
        description="The candidates; `goal_index` of the result says which one was reached"
    )
    frame: Name | None = Field(
        default=None, description="The tool frame: any that the group moves; null for its default"
    )
    tolerance: ToleranceWire = Field(
        default_factory=ToleranceWire, description="How far off it may be"
    )
    approach: Triple | None = Field(
        default=None,
        description="The motion ends in a straight line without a turn, which begins where the "
        "tool is displaced by this, in the target's axes [m]; null for none",
    )
    retreat: Triple | None = Field(
        default=None,
        description="After the goal the tool goes on in a straight line by this, in the target's "
        "axes [m]; null for none",
    )


class LineGoalWire(Wire):
    """Bring a tool frame to a pose in a straight line from the start."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"type": "line", "pose": {"position": [0, 0, -0.05], "frame": "arm::tcp"}}]
        }
    )

    type: Literal["line"] = Field(description="Says which goal this is")
    pose: PoseWire = Field(
        description="Where the line ends; the rotation turns along with the translation"
    )
    frame: Name | None = Field(
        default=None, description="The tool frame: any that the group moves; null for its default"
    )
    deviation: DeviationWire = Field(
        default_factory=DeviationWire,
        description="How far from the line the motion may be, between samples too",
    )


class PathGoalWire(Wire):
    """Bring a tool frame through poses in straight lines, at rest at each."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "type": "path",
                    "poses": [
                        {"position": [0.4, 0.2, 0.3], "quaternion": [0, 1, 0, 0]},
                        {"position": [0.4, 0.3, 0.3], "quaternion": [0, 1, 0, 0]},
                    ],
                }
            ]
        }
    )

    type: Literal["path"] = Field(description="Says which goal this is")
    poses: Annotated[list[PoseWire], Field(min_length=1, max_length=1000)] = Field(
        description="In this order; frames that move count where the start puts them"
    )
    frame: Name | None = Field(
        default=None, description="The tool frame: any that the group moves; null for its default"
    )
    deviation: DeviationWire = Field(
        default_factory=DeviationWire,
        description="How far from the lines the motion may be, between samples too",
    )


type GoalWire = Annotated[
    Annotated[
        JointGoalWire | ConfigurationGoalWire | PoseGoalWire | LineGoalWire | PathGoalWire,
        Field(discriminator="type", description="What a motion shall reach"),
    ],
    BeforeValidator(_known_type),
]
