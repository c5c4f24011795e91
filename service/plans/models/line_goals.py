"""Goals that are straight lines, and the tool frame that a goal is for."""

from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from planning.domain.goals import goal as domain
from planning.domain.goals.linear_moves import Displacement
from service.api.arrays import vector
from service.api.models import FrameName, Pose, Real, RequestModel, Triple

type Shift = Annotated[Real, Field(ge=1e-6, le=1)]
type Turn = Annotated[Real, Field(ge=1e-5, le=3)]
type ToolFrame = Annotated[
    FrameName | None,
    Field(description="The tool frame: any that the group moves; null for its default"),
]


class Deviation(RequestModel):
    """Deviation of a tool from its line that is allowed, between waypoints and samples too."""

    position: Shift = Field(
        default=0.001, description="Distance of the tool's origin from the line [m]"
    )
    rotation: Turn = Field(
        default=0.008726646259971648,
        description="Angle between the tool's rotation and that of the line [rad]",
    )


class Translation(RequestModel):
    """A translation without a rotation."""

    vector: Triple = Field(description="Translation [m]")
    frame: FrameName = Field(
        default="world", description="Frame in whose axes the vector is, as they stand at the start"
    )

    def to_domain(self) -> Displacement:
        """Return the domain's displacement."""
        return Displacement(vector(self.vector), self.frame)


class LineTarget(RequestModel):
    """Where a straight line ends that begins where the tool stands."""

    pose: Pose | None = Field(
        default=None,
        description="Pose at which the line ends, and the rotation turns along with the "
        "translation; this or `displacement`",
    )
    displacement: Translation | None = Field(
        default=None, description="Displacement from where the tool stands; this or `pose`"
    )

    @model_validator(mode="after")
    def _one_end(self) -> Self:
        if (self.pose is None) == (self.displacement is None):
            message = "give `pose` or `displacement`, and not both"
            raise ValueError(message)
        return self

    def to_target(self) -> domain.PoseTarget | Displacement:
        """Return where the line leads."""
        if self.pose is not None:
            return self.pose.to_target()
        return (self.displacement or Translation(vector=[0.0, 0.0, 0.0])).to_domain()


class LineGoal(LineTarget):
    """Bring a tool frame to a pose, or by a displacement, in a straight line from the start."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"type": "line", "displacement": {"vector": [0, 0, 0.1]}},
                {"type": "line", "pose": {"position": [0, 0, -0.05], "frame": "arm::tcp"}},
            ]
        }
    )

    type: Literal["line"] = Field(description="Kind of goal")
    frame: ToolFrame = None
    deviation: Deviation = Field(
        default_factory=Deviation,
        description="Largest deviation of the motion from the line, between samples too",
    )

    def to_domain(self) -> domain.LineGoal:
        """Return the domain's goal of one line."""
        return _lines((self.to_target(),), self.frame, self.deviation)


class PathGoal(RequestModel):
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

    type: Literal["path"] = Field(description="Kind of goal")
    poses: Annotated[list[Pose], Field(min_length=1, max_length=1000)] = Field(
        description="Poses in this order; frames that move count where the start puts them"
    )
    frame: ToolFrame = None
    deviation: Deviation = Field(
        default_factory=Deviation,
        description="Largest deviation of the motion from the lines, between samples too",
    )

    def to_domain(self) -> domain.LineGoal:
        """Return the domain's goal of several lines."""
        targets = tuple(pose.to_target() for pose in self.poses)
        return _lines(targets, self.frame, self.deviation)


def _lines(
    targets: tuple[domain.PoseTarget | Displacement, ...], frame: str | None, deviation: Deviation
) -> domain.LineGoal:
    return domain.LineGoal(targets, frame or "", deviation.position, deviation.rotation)
