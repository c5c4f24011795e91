"""Path constraints: what a motion shall keep on its whole way."""

import math
from collections.abc import Iterable, Sequence
from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from planning.domain.request import constraint as domain
from service.api.arrays import vector
from service.api.models import (
    BodyName,
    FrameName,
    JointName,
    NonNegative,
    Pose,
    PositionName,
    Real,
    RequestModel,
    Triple,
)

type Side = Annotated[Real, Field(gt=0, le=1e6)]
type BodyNames = Annotated[list[BodyName], Field(min_length=1, max_length=1000)]
type JointNames = Annotated[list[JointName], Field(min_length=1, max_length=1000)]

_SHORTEST = 1e-9


class Box(RequestModel):
    """A box, placed by the pose of its middle."""

    size: Annotated[list[Side], Field(min_length=3, max_length=3)] = Field(
        description="Full side lengths along the axes of `pose` [m]"
    )
    pose: Pose = Field(
        default_factory=lambda: Pose(position=[0.0, 0.0, 0.0]),
        description="Pose of its middle; in a frame that moves with the group, as the start "
        "puts it",
    )

    def to_domain(self) -> domain.PlacedBox:
        """Return the domain's box."""
        return _placed(self.size, self.pose)


def _placed(size: Sequence[float | None], pose: Pose) -> domain.PlacedBox:
    """Return the domain's box; sides that are null are infinite."""
    sides = vector([math.inf if side is None else side for side in size])
    return domain.PlacedBox(sides, pose.to_domain(), pose.frame)


class DistanceBand(RequestModel):
    """The smallest distance between two sets of bodies stays within bounds."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"type": "distance_band", "min": 0.01, "max": 0.05}]}
    )

    type: Literal["distance_band"] = Field(description="Kind of constraint")
    bodies: BodyNames | None = Field(
        default=None,
        description="Full names of the first set of bodies; null for all "
        "bodies that the group moves",
    )
    to: BodyNames | None = Field(
        default=None,
        description="Full names of the second set of bodies; null for all not in `bodies`",
    )
    min: Annotated[NonNegative, Field(le=10)] = Field(
        default=0.0, description="Least distance that any two of them keep [m]"
    )
    max: Annotated[Real, Field(gt=0, le=10)] | None = Field(
        default=None, description="Largest value of the smallest distance [m]; null for no bound"
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.max is not None and not self.min < self.max:
            message = "`min` must be less than `max`"
            raise ValueError(message)
        return self

    def to_domain(self) -> domain.DistanceBand:
        """Return the domain's constraint."""
        return domain.DistanceBand(
            bodies=None if self.bodies is None else tuple(self.bodies),
            to=None if self.to is None else tuple(self.to),
            min=self.min,
            max=math.inf if self.max is None else self.max,
        )


class KeepOut(RequestModel):
    """The origin of a frame stays out of a box."""

    type: Literal["keep_out"] = Field(description="Kind of constraint")
    frame: FrameName = Field(description="Frame whose origin is meant")
    box: Box = Field(description="Box in which the origin must not be")

    def to_domain(self) -> domain.KeepOut:
        """Return the domain's constraint."""
        return domain.KeepOut(self.frame, self.box.to_domain())


class KeepIn(RequestModel):
    """The origin of a frame stays in a box."""

    type: Literal["keep_in"] = Field(description="Kind of constraint")
    frame: FrameName = Field(description="Frame whose origin is meant")
    box: Box = Field(description="Box in which the origin must be")

    def to_domain(self) -> domain.KeepIn:
        """Return the domain's constraint."""
        return domain.KeepIn(self.frame, self.box.to_domain())


class Position(RequestModel):
    """The origin of a frame stays near a line, a plane or a point."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "type": "position",
                    "frame": "arm::tcp",
                    "size": [None, None, 0.01],
                    "pose": {"position": [0, 0, 0.3]},
                }
            ]
        }
    )

    type: Literal["position"] = Field(description="Kind of constraint")
    frame: FrameName = Field(description="Frame whose origin is meant")
    size: Annotated[list[Side | None], Field(min_length=3, max_length=3)] = Field(
        description="Width of the band along each axis of `pose` [m]; null for an axis "
        "that is free: one number is a plane, two are a line"
    )
    pose: Pose = Field(
        default_factory=lambda: Pose(position=[0.0, 0.0, 0.0]),
        description="Pose of its middle; in a frame that moves with the group, as the start "
        "puts it",
    )

    @model_validator(mode="after")
    def _is_bounded(self) -> Self:
        if all(side is None for side in self.size):
            message = "`size` must have at least one number"
            raise ValueError(message)
        return self

    def to_domain(self) -> domain.PositionBand:
        """Return the domain's constraint."""
        return domain.PositionBand(self.frame, _placed(self.size, self.pose))


class Orientation(RequestModel):
    """An axis of a frame stays within an angle of a direction; turns about the axis are free."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "type": "orientation",
                    "frame": "arm::tcp",
                    "axis": [0, 0, 1],
                    "direction": [0, 0, -1],
                    "tolerance": 0.1,
                }
            ]
        }
    )

    type: Literal["orientation"] = Field(description="Kind of constraint")
    frame: FrameName = Field(description="Frame whose axis is meant")
    axis: Triple = Field(description="Axis in that frame; any length but zero")
    direction: Triple = Field(description="Direction in `reference`; any length but zero")
    tolerance: Annotated[Real, Field(gt=0, le=math.pi)] = Field(
        description="Largest angle between them [rad]"
    )
    reference: FrameName = Field(
        default="world",
        description="Frame in whose axes `direction` is given; a frame that moves counts "
        "as the start has it",
    )

    @model_validator(mode="after")
    def _has_length(self) -> Self:
        for name, numbers in (("axis", self.axis), ("direction", self.direction)):
            if not math.hypot(*numbers) > _SHORTEST:
                message = f"`{name}` must not be zero"
                raise ValueError(message)
        return self

    def to_domain(self) -> domain.OrientationCone:
        """Return the domain's constraint."""
        return domain.OrientationCone(
            frame=self.frame,
            axis=vector(self.axis),
            direction=vector(self.direction),
            tolerance=self.tolerance,
            reference=self.reference,
        )


class LockedJoints(RequestModel):
    """Some joints of the group stay where the start has them."""

    type: Literal["locked_joints"] = Field(description="Kind of constraint")
    joints: JointNames = Field(description="Full names")

    def to_domain(self) -> domain.LockedJoints:
        """Return the domain's constraint."""
        return domain.LockedJoints(tuple(self.joints))


class JointLimits(RequestModel):
    """Some coordinates of the group stay within bounds, besides those of the robot."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"type": "joint_limits", "limits": {"arm::elbow_joint": [0.5, 2.5]}}]
        }
    )

    type: Literal["joint_limits"] = Field(description="Kind of constraint")
    limits: dict[PositionName, Annotated[list[Real], Field(min_length=2, max_length=2)]] = Field(
        min_length=1,
        max_length=256,
        description="Smallest and largest position by the name of a joint, or of a coordinate of "
        "one that has several [rad or m]",
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        for name, (low, high) in self.limits.items():
            if low > high:
                message = f"limits of {name!r}: the lower one must not exceed the upper one"
                raise ValueError(message)
        return self

    def to_domain(self) -> domain.TightLimits:
        """Return the domain's constraint."""
        return domain.TightLimits({name: (low, high) for name, (low, high) in self.limits.items()})


type Constraint = Annotated[
    DistanceBand | KeepOut | KeepIn | Position | Orientation | LockedJoints | JointLimits,
    Field(discriminator="type", description="Constraint on a whole motion"),
]


def constraints_to_domain(constraints: Iterable[Constraint]) -> tuple[domain.PathConstraint, ...]:
    """Return the domain's constraints, in the same order."""
    return tuple(constraint.to_domain() for constraint in constraints)
