"""Goals: what a motion shall reach."""

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from planning.domain.geometry import pose as geometry
from planning.domain.goals import goal as domain
from service.api.models import (
    ConfigurationName,
    FrameName,
    GroupPositions,
    Quadruple,
    RequestModel,
    Triple,
    require_one_rotation,
)
from service.plans.models.line_goals import LineGoal, PathGoal, ToolFrame
from service.plans.models.pose_goals import PoseGoal, RegionGoal


class JointGoal(RequestModel):
    """Reach a configuration, or any of several."""

    type: Literal["joint"] = Field(description="Kind of goal")
    positions: (
        GroupPositions | Annotated[list[GroupPositions], Field(min_length=1, max_length=1000)]
    ) = Field(description="The group's positions, one list or several [rad or m]")

    def to_domain(self) -> domain.JointGoal:
        """Return the domain's goal."""
        return domain.JointGoal(np.atleast_2d(np.array(self.positions, dtype=np.float64)))


class ConfigurationGoal(RequestModel):
    """Reach a configuration that the scene or the robot names."""

    type: Literal["configuration"] = Field(description="Kind of goal")
    name: ConfigurationName = Field(description="Name of the configuration, for example `home`")

    def to_domain(self) -> domain.ConfigurationGoal:
        """Return the domain's goal."""
        return domain.ConfigurationGoal(self.name)


class Displacement(RequestModel):
    """A displacement: a translation, a rotation, or both."""

    position: Triple | None = Field(default=None, description="Translation [m]; null for none")
    quaternion: Quadruple | None = Field(
        default=None, description="Rotation as [w, x, y, z]; normalised when read, never zero"
    )
    rpy: Triple | None = Field(
        default=None, description="Rotation as roll, pitch, yaw about fixed x, y, z [rad]"
    )

    @model_validator(mode="after")
    def _something(self) -> Self:
        if self.position is None and self.quaternion is None and self.rpy is None:
            message = "give `position`, `quaternion` or `rpy`"
            raise ValueError(message)
        require_one_rotation(self.quaternion, self.rpy)
        return self

    def to_domain(self) -> geometry.Pose:
        """Return the domain's pose of what is displaced, before it."""
        position = self.position or (0.0, 0.0, 0.0)
        return geometry.Pose.from_parts(position, self.quaternion, self.rpy)


class RelativeGoal(RequestModel):
    """Move a tool frame by a displacement from where the start has it."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "type": "relative",
                    "displacement": {"position": [0, 0, 0.05]},
                    "reference": "world",
                }
            ]
        }
    )

    type: Literal["relative"] = Field(description="Kind of goal")
    displacement: Displacement = Field(
        description="Displacement from where the tool is at the start"
    )
    frame: ToolFrame = None
    reference: FrameName | None = Field(
        default=None,
        description="Frame in whose axes, as they are at the start, the tool is shifted, "
        "and turned about its own origin; null for the tool frame itself",
    )

    def to_domain(self) -> domain.RelativeGoal:
        """Return the domain's goal."""
        displacement = self.displacement.to_domain()
        return domain.RelativeGoal(displacement, self.frame or "", self.reference or "")


type Goal = Annotated[
    JointGoal | ConfigurationGoal | PoseGoal | RegionGoal | RelativeGoal | LineGoal | PathGoal,
    Field(discriminator="type", description="Goal of a motion"),
]
