"""Goals: what a motion shall reach."""

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from planning.domain.arrays import Array
from planning.domain.geometry import pose as geometry
from planning.domain.goals import goal as domain
from service.api.arrays import vector
from service.api.models import (
    ConfigurationName,
    FrameName,
    GroupPositions,
    NonNegative,
    Pose,
    Quadruple,
    Real,
    RequestModel,
    Triple,
    require_one_rotation,
)
from service.plans.models.line_goals import LineGoal, PathGoal, ToolFrame


def _optional(numbers: list[float] | None) -> Array | None:
    return None if numbers is None else vector(numbers)


class Tolerance(RequestModel):
    """How far from a target the tool frame may end, in the target's own axes."""

    position: Annotated[list[NonNegative], Field(min_length=3, max_length=3)] = Field(
        default=[0.0, 0.0, 0.0], description="Half-widths of a box about the target [m]"
    )
    rotation: Annotated[list[NonNegative], Field(min_length=3, max_length=3)] = Field(
        default=[0.0, 0.0, 0.0],
        description="Largest rotation about each axis [rad]; pi or more leaves the axis free",
    )


class JointGoal(RequestModel):
    """Reach a configuration, or any of several."""

    type: Literal["joint"] = Field(description="Says which goal this is")
    positions: (
        GroupPositions | Annotated[list[GroupPositions], Field(min_length=1, max_length=1000)]
    ) = Field(description="The group's positions, one list or several [rad or m]")

    def to_domain(self) -> domain.JointGoal:
        """Return the domain's goal."""
        return domain.JointGoal(np.atleast_2d(np.array(self.positions, dtype=np.float64)))


class ConfigurationGoal(RequestModel):
    """Reach a configuration that the scene or the robot names."""

    type: Literal["configuration"] = Field(description="Says which goal this is")
    name: ConfigurationName = Field(description="Of the configuration, for example `home`")

    def to_domain(self) -> domain.ConfigurationGoal:
        """Return the domain's goal."""
        return domain.ConfigurationGoal(self.name)


type Weight = Annotated[Real, Field(ge=0, le=1e3)]


class PoseDistanceTolerance(RequestModel):
    """All poses within a weighted distance: sqrt(sum (w_i * way_i)^2 + (w_r * angle)^2)."""

    tolerance: Annotated[Real, Field(ge=1e-6, le=1e3)] = Field(
        description="The largest distance [1]"
    )
    weights: Annotated[list[Weight], Field(min_length=4, max_length=4)] = Field(
        default=[1.0, 1.0, 1.0, 0.1],
        description="w_x, w_y, w_z [1/m] and w_r [1/rad]; what has no weight is free",
    )
    frame: FrameName | None = Field(
        default=None,
        description="By whose axes the way from the target's origin is, as they stand at the "
        "start: any frame; null for the target's own",
    )

    def to_domain(self) -> domain.PoseBall:
        """Return the domain's tolerance."""
        return domain.PoseBall(self.tolerance, vector(self.weights), self.frame or "")


class PoseGoal(RequestModel):
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
    poses: Annotated[list[Pose], Field(min_length=1, max_length=1000)] = Field(
        description="The candidates; `goal_index` of the result says which one was reached"
    )
    frame: ToolFrame = None
    tolerance: Tolerance = Field(default_factory=Tolerance, description="How far off it may be")
    metric: PoseDistanceTolerance | None = Field(
        default=None,
        description="Instead of `tolerance`: how far off it may be by a weighted metric",
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

    @model_validator(mode="after")
    def _one_tolerance(self) -> Self:
        if self.metric is not None and any([*self.tolerance.position, *self.tolerance.rotation]):
            message = "give `tolerance` or `metric`, and not both"
            raise ValueError(message)
        return self

    def to_domain(self) -> domain.PoseGoal:
        """Return the domain's goal."""
        return domain.PoseGoal(
            targets=tuple(pose.to_target() for pose in self.poses),
            frame=self.frame or "",
            position_tolerance=vector(self.tolerance.position),
            rotation_tolerance=vector(self.tolerance.rotation),
            approach=_optional(self.approach),
            retreat=_optional(self.retreat),
            ball=None if self.metric is None else self.metric.to_domain(),
        )


class RegionGoal(RequestModel):
    """Bring a tool frame anywhere into a region, or into any of several."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "type": "region",
                    "pose": {"position": [0.45, 0.25, 0.4], "rpy": [3.1416, 0, 0]},
                    "tolerance": {"position": [0.05, 0.05, 0], "rotation": [0.1, 0.1, 0]},
                    "free_axes": ["rz"],
                }
            ]
        }
    )

    type: Literal["region"] = Field(description="Says which goal this is")
    poses: Annotated[list[Pose], Field(min_length=1, max_length=1000)] | None = Field(
        default=None, description="The middles of the regions; or one as `pose`"
    )
    pose: Pose | None = Field(default=None, description="The middle of the only region")
    frame: ToolFrame = None
    tolerance: Tolerance = Field(
        default_factory=Tolerance,
        description="How far from the middle the region goes, by its axes",
    )
    free_axes: Annotated[list[Literal["x", "y", "z", "rx", "ry", "rz"]], Field(max_length=6)] = (
        Field(
            default=[],
            description="Axes of the region that it is unbounded along (`x`, `y`, `z`: as far as "
            "the group reaches) or free to turn about (`rx`, `ry`, `rz`)",
        )
    )

    approach: Triple | None = Field(
        default=None,
        description="As of a pose: the last way to wherever in the region the motion ends begins "
        "where the tool is displaced by this, in the region's axes [m]; null for none",
    )
    retreat: Triple | None = Field(
        default=None,
        description="As of a pose: the way that the tool goes on, in the region's axes [m]; null "
        "for none",
    )

    @model_validator(mode="after")
    def _one_or_several(self) -> Self:
        if (self.pose is None) == (self.poses is None):
            message = "give `pose` or `poses`, and not both"
            raise ValueError(message)
        return self

    def to_domain(self) -> domain.RegionGoal:
        """Return the domain's goal; what is free has no bound."""
        poses = self.poses if self.pose is None else [self.pose]
        position, rotation = vector(self.tolerance.position), vector(self.tolerance.rotation)
        position[[axis in self.free_axes for axis in ("x", "y", "z")]] = math.inf
        rotation[[axis in self.free_axes for axis in ("rx", "ry", "rz")]] = math.pi
        return domain.RegionGoal(
            targets=tuple(pose.to_target() for pose in poses or ()),
            frame=self.frame or "",
            position_tolerance=position,
            rotation_tolerance=rotation,
            approach=_optional(self.approach),
            retreat=_optional(self.retreat),
        )


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

    type: Literal["relative"] = Field(description="Says which goal this is")
    displacement: Displacement = Field(description="By how much")
    frame: ToolFrame = None
    reference: FrameName | None = Field(
        default=None,
        description="The frame by whose axes, as they are at the start, the tool is shifted, and "
        "turned about its own origin; null for the tool frame itself",
    )

    def to_domain(self) -> domain.RelativeGoal:
        """Return the domain's goal."""
        displacement = self.displacement.to_domain()
        return domain.RelativeGoal(displacement, self.frame or "", self.reference or "")


type Goal = Annotated[
    JointGoal | ConfigurationGoal | PoseGoal | RegionGoal | RelativeGoal | LineGoal | PathGoal,
    Field(discriminator="type", description="What a motion shall reach"),
]
