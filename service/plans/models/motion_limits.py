"""Limits on a motion besides those of its joints."""

from typing import Annotated, Any, Self, TypedDict

from pydantic import ConfigDict, Field, model_validator

from planning.domain.request import motion_limits as domain
from planning.domain.robot import payload as robot
from planning.errors import ProblemInvalid
from service.api.models import (
    Boolean,
    Coordinate,
    FrameName,
    Name,
    Real,
    RequestModel,
    Scale,
    Triple,
)
from service.plans.models.constraints import Box
from service.scenes.models.summary import Group

type Speed = Annotated[Real, Field(ge=1e-3, le=1e3)]
type AccelerationPair = Annotated[list[Coordinate], Field(min_length=2, max_length=2)]
type Moments = Annotated[list[Coordinate], Field(min_length=6, max_length=6)]

EXAMPLE_PAYLOAD: dict[str, Any] = {
    "frame": "arm::tool0",
    "mass": 2.0,
    "center_of_mass": [0, 0, 0.05],
}


class ToolLimit(RequestModel):
    """Limits on the speed and acceleration of the origin of a frame."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"frame": "arm::tcp", "speed": 0.25, "acceleration": 1.0}]}
    )

    frame: FrameName = Field(description="Any frame of the scene; each is limited once")
    speed: Speed | None = Field(default=None, description="Largest speed [m/s]; null for any")
    acceleration: Annotated[Real, Field(ge=1e-2, le=1e4)] | None = Field(
        default=None, description="Largest acceleration in any direction [m/s^2]; null for any"
    )

    @model_validator(mode="after")
    def _limits_something(self) -> Self:
        if self.speed is None and self.acceleration is None:
            message = "give `speed`, `acceleration` or both"
            raise ValueError(message)
        return self

    def to_domain(self) -> domain.ToolLimit:
        """Return the domain's limit."""
        return domain.ToolLimit(self.frame, self.speed, self.acceleration)


class SpeedZone(RequestModel):
    """Largest speed of the origin of a frame while it is in a box."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "name": "table",
                    "frame": "arm::tcp",
                    "box": {"size": [0.6, 0.6, 0.2], "pose": {"position": [0.5, 0.0, 0.1]}},
                    "speed": 0.1,
                }
            ]
        }
    )

    name: Name = Field(description="Name for the certificate's check; no two zones share one")
    frame: FrameName = Field(description="Frame whose origin is limited: any frame of the scene")
    box: Box = Field(description="Box in which the speed is limited")
    speed: Speed = Field(description="Largest speed in the box [m/s]")

    def to_domain(self) -> domain.SpeedZone:
        """Return the domain's zone."""
        return domain.SpeedZone(self.name, self.frame, self.box.to_domain(), self.speed)


class Payload(RequestModel):
    """A rigid mass that follows a frame and burdens every joint that carries it."""

    model_config = ConfigDict(title="Payload", json_schema_extra={"examples": [EXAMPLE_PAYLOAD]})

    frame: FrameName = Field(description="Frame that the mass follows; the group must move it")
    mass: Annotated[Real, Field(gt=0, le=1e4)] = Field(description="Mass [kg]")
    center_of_mass: Triple = Field(
        default=[0.0, 0.0, 0.0], description="Center of mass in the frame [m]"
    )
    inertia: Moments = Field(
        default=[0.0] * 6,
        description="Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the centre of mass, along the frame's axes "
        "[kg m^2]; zeros for a point mass",
    )

    @model_validator(mode="after")
    def _could_be_a_body(self) -> Self:
        try:
            self.to_domain()
        except ProblemInvalid as fault:
            raise ValueError(fault.detail) from fault
        return self

    def to_domain(self) -> robot.Payload:
        """Return the domain's payload."""
        return robot.Payload.from_parts(self.frame, self.mass, self.center_of_mass, self.inertia)


class LimitFields(TypedDict):
    """Fields of the domain's `RetimeOptions`."""

    velocity_scale: float
    acceleration_scale: float
    tool_limits: tuple[domain.ToolLimit, ...]
    speed_zones: tuple[domain.SpeedZone, ...]
    acceleration_bounds: domain.AccelerationBounds
    effort: bool
    payload: robot.Payload | None


class MotionLimits(RequestModel):
    """What limits a motion besides the limits of its joints; the scales do not change it."""

    tool_limits: Annotated[list[ToolLimit], Field(max_length=16)] = Field(
        default=[], description="Largest speeds and accelerations of frames"
    )
    speed_zones: Annotated[list[SpeedZone], Field(max_length=64)] = Field(
        default=[], description="Boxes in which a frame is slower"
    )
    acceleration_bounds: Annotated[dict[Name, AccelerationPair], Field(max_length=256)] = Field(
        default={},
        description="Lowest (below 0) and highest (above 0) acceleration, by name of a joint with "
        "one coordinate, or `joint.angular` of a planar one [rad/s^2 or m/s^2]",
    )
    effort: Boolean = Field(
        default=False,
        description="Whether joint torques and forces must stay within their limits, "
        "gravity and all that is carried included: check `torque` of the "
        "certificate",
    )
    payload: Payload | None = Field(
        default=None,
        description="Mass that the group carries and the scene does not show; it counts "
        "for torques",
    )

    @model_validator(mode="after")
    def _distinct(self) -> Self:
        for what, names in (
            ("tool_limits: frame", [limit.frame for limit in self.tool_limits]),
            ("speed_zones: name", [zone.name for zone in self.speed_zones]),
        ):
            twice = sorted({name for name in names if names.count(name) > 1})
            if twice:
                message = f"{what} {twice[0]!r} comes twice"
                raise ValueError(message)
        for name, (low, high) in self.acceleration_bounds.items():
            if not low < 0 < high:
                message = f"acceleration_bounds of {name!r}: the lowest must be below 0, "
                raise ValueError(message + "the highest above")
        return self

    def check_group(self, group: Group) -> None:
        """Go on only if the group's motions can be limited so.

        Raises:
            UnknownName: A joint does not exist, or has several coordinates.
            ProblemInvalid: Efforts shall be kept, and no joint of the group has a limit on them.
        """
        if self.effort and all(bound is None for bound in group.limits.effort):
            raise domain.missing_effort_limits(group.name)
        if self.acceleration_bounds:
            domain.validate_signed_blocks(self.acceleration_bounds, group.domain_joints)


class ScaledLimits(MotionLimits):
    """What limits a motion, and how much of the limits of its joints it may use."""

    velocity_scale: Scale = Field(default=1.0, description="Factor on every velocity limit, 0..1")
    acceleration_scale: Scale = Field(
        default=1.0, description="Factor on every acceleration and jerk limit, 0..1"
    )

    def limit_fields(self) -> LimitFields:
        """Return the limits, and the scales, as fields of the options of the timing."""
        return LimitFields(
            velocity_scale=self.velocity_scale,
            acceleration_scale=self.acceleration_scale,
            tool_limits=tuple(limit.to_domain() for limit in self.tool_limits),
            speed_zones=tuple(zone.to_domain() for zone in self.speed_zones),
            acceleration_bounds={
                name: (low, high) for name, (low, high) in self.acceleration_bounds.items()
            },
            effort=self.effort,
            payload=None if self.payload is None else self.payload.to_domain(),
        )
