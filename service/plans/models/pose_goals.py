"""Goals about poses of a tool: to reach one of some, or a region about one."""

import math
from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from planning.domain.arrays import Array
from planning.domain.goals import goal as domain
from service.api.arrays import vector
from service.api.models import FrameName, NonNegative, Pose, Real, RequestModel, Triple
from service.plans.models.line_goals import ToolFrame


def _optional(numbers: list[float] | None) -> Array | None:
    return None if numbers is None else vector(numbers)


class Tolerance(RequestModel):
    """Tolerance of the tool frame about a target, in the target's own axes."""

    position: Annotated[list[NonNegative], Field(min_length=3, max_length=3)] = Field(
        default=[0.0, 0.0, 0.0], description="Half-widths of a box about the target [m]"
    )
    rotation: Annotated[list[NonNegative], Field(min_length=3, max_length=3)] = Field(
        default=[0.0, 0.0, 0.0],
        description="Largest rotation about each axis [rad]; pi or more leaves the axis free",
    )


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
        description="Frame in whose axes the way from the target's origin is measured, as "
        "they stand at the start: any frame; null for the target's own",
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

    type: Literal["pose"] = Field(description="Kind of goal")
    poses: Annotated[list[Pose], Field(min_length=1, max_length=1000)] = Field(
        description="The candidates; `goal_index` of the result says which one was reached"
    )
    frame: ToolFrame = None
    tolerance: Tolerance = Field(default_factory=Tolerance, description="Tolerance of the pose")
    metric: PoseDistanceTolerance | None = Field(
        default=None,
        description="Tolerance by a weighted metric, instead of `tolerance`",
    )
    approach: Triple | None = Field(
        default=None,
        description="Displacement of the tool, in the target's axes, at which the last "
        "straight line to the goal begins [m]; the tool does not turn on it; "
        "null for none",
    )
    retreat: Triple | None = Field(
        default=None,
        description="Displacement of the tool, in the target's axes, in a straight line "
        "after the goal [m]; null for none",
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

    type: Literal["region"] = Field(description="Kind of goal")
    poses: Annotated[list[Pose], Field(min_length=1, max_length=1000)] | None = Field(
        default=None, description="Middles of the regions; or one as `pose`"
    )
    pose: Pose | None = Field(default=None, description="Middle of the only region")
    frame: ToolFrame = None
    tolerance: Tolerance = Field(
        default_factory=Tolerance,
        description="Extent of the region from its middle, by its axes",
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
        description="Displacement of the tool, in the region's axes, at which the last "
        "straight line to the motion's end in the region begins [m]; null for "
        "none",
    )
    retreat: Triple | None = Field(
        default=None,
        description="Displacement of the tool, in the region's axes, in a straight line "
        "after the goal [m]; null for none",
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
