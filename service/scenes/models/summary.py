"""What a loaded robot or scene holds."""

from collections.abc import Sequence
from typing import Any, Self

from pydantic import ConfigDict, Field

from planning.domain.robot import joints as domain
from planning.domain.robot.spanning_group import joined_name
from planning.domain.robot.steering import steering_of
from planning.domain.scene.summary import GroupSummary, RobotSummary
from service.api.models import ResponseModel, bounds

type Bound = float | None


def _is_none(part: Any) -> bool:
    return part is None


def _is_empty(members: list[str]) -> bool:
    return not members


class Steering(ResponseModel):
    """Curves that a car can drive."""

    model_config = ConfigDict(from_attributes=True)

    turning_radius: float = Field(
        description="Radius of its tightest turn, at the base's origin [m]"
    )
    reverse: bool = Field(description="Whether it drives backwards too")


class Joint(ResponseModel):
    """A joint of a group."""

    name: str = Field(description="Full name, `robot::joint`")
    type: domain.JointType = Field(
        description="Type of the joint. Whole turns are nothing only to continuous "
        "joints; a joint that another one follows by less is revolute"
    )
    steering: Steering | None = Field(
        default=None, description="Steering of a planar joint; null if it moves any way"
    )


class Limits(ResponseModel):
    """Limits of the joints of a group; null is unlimited.

    Positions are limited per coordinate, rates per block by the Euclidean norm of its velocity
    coordinates; a scalar joint is a block of its own. Joints that follow those of the group keep
    their own limits within these.
    """

    lower: list[Bound] = Field(description="Smallest positions [rad or m]")
    upper: list[Bound] = Field(description="Largest positions [rad or m]")
    blocks: list[str] = Field(description="Names of the blocks, in the order of the rates")
    velocity: list[Bound] = Field(description="Largest velocity per block [rad/s or m/s]")
    acceleration: list[Bound] = Field(
        description="Largest acceleration per block [rad/s^2 or m/s^2]"
    )
    jerk: list[Bound] = Field(description="Largest jerk per block [rad/s^3 or m/s^3]")
    effort: list[Bound] = Field(description="Largest torque or force per block [N m or N]")

    @classmethod
    def from_domain(cls, limits: domain.JointLimits, blocks: list[str]) -> Self:
        """Return limits by the names of their blocks."""
        return cls(
            lower=bounds(limits.lower),
            upper=bounds(limits.upper),
            blocks=blocks,
            velocity=bounds(limits.velocity),
            acceleration=bounds(limits.acceleration),
            jerk=bounds(limits.jerk),
            effort=bounds(limits.effort),
        )


class Gripper(ResponseModel):
    """Width of a group that is a parallel gripper: `travel` times (position - `lower`)."""

    model_config = ConfigDict(from_attributes=True)

    joint: str = Field(description="Full name of the joint that moves its fingers")
    lower: float = Field(description="Position of that joint where the fingers meet [m]")
    travel: float = Field(
        description="Distance that the fingers part with each metre of the joint [m/m]"
    )
    max_width: float = Field(description="Largest distance of the fingers [m]")


class Group(ResponseModel):
    """Joints that are planned for together."""

    name: str = Field(description="`robot`, `robot::group`, or its own in the scene")
    aliases: list[str] = Field(description="Other names that it answers to")
    members: list[str] = Field(
        default=[],
        description="Groups of robots that it spans, in order; left out of one of these",
        exclude_if=_is_empty,
    )
    joints: list[Joint] = Field(description="Joints in the group's order")
    position_names: list[str] = Field(description="A name per position coordinate, in order")
    velocity_names: list[str] = Field(description="A name per velocity coordinate, in order")
    tool_frames: list[str] = Field(description="Frames that it moves; the first is the default")
    limits: Limits = Field(description="Limits of its joints")
    configurations: dict[str, list[float]] = Field(
        description="Named configurations, in the group's order [rad or m]"
    )
    positions: list[float] = Field(description="The current state [rad or m]")
    gripper: Gripper | None = Field(
        default=None,
        description="Width of a group that is a gripper; left out of other groups",
        exclude_if=_is_none,
    )

    @property
    def domain_joints(self) -> list[domain.Joint]:
        """Its joints as the domain has them."""
        return [domain.Joint(joint.name, joint.type) for joint in self.joints]

    @classmethod
    def from_summary(cls, summary: GroupSummary, aliases: Sequence[str]) -> Self:
        """Return a group with its other names."""
        group = summary.group
        cars = steering_of(group)
        joints = [
            Joint(
                name=joint.name,
                type=joint.type,
                steering=Steering.model_validate(cars[joint.name]) if joint.name in cars else None,
            )
            for joint in group.joints
        ]
        return cls(
            name=group.name,
            aliases=list(aliases),
            members=list(summary.members),
            joints=joints,
            position_names=list(group.position_names),
            velocity_names=list(group.velocity_names),
            tool_frames=list(group.tool_frames),
            limits=Limits.from_domain(summary.limits, [name for name, _ in group.blocks]),
            configurations={name: list(q) for name, q in summary.configurations.items()},
            positions=list(summary.positions),
            gripper=None if summary.gripper is None else Gripper.model_validate(summary.gripper),
        )

    @classmethod
    def spanning(cls, members: Sequence["Group"]) -> Self:
        """Return the group that spans some groups of robots, which have no joint in common."""
        first = members[0]
        shared = set.intersection(*(set(member.configurations) for member in members))
        return cls(
            name=joined_name([member.name for member in members]),
            aliases=[],
            members=[member.name for member in members],
            joints=_stacked(members, "joints"),
            position_names=_stacked(members, "position_names"),
            velocity_names=_stacked(members, "velocity_names"),
            tool_frames=list(dict.fromkeys(_stacked(members, "tool_frames"))),
            limits=Limits(**{
                name: _stacked([member.limits for member in members], name)
                for name in Limits.model_fields
            }),
            configurations={
                name: [x for member in members for x in member.configurations[name]]
                for name in first.configurations
                if name in shared
            },
            positions=_stacked(members, "positions"),
        )


def _stacked(parts: Sequence[ResponseModel], field: str) -> list[Any]:
    """Return the lists that some parts have in a field, one after the other."""
    return [entry for part in parts for entry in getattr(part, field)]


class Source(ResponseModel):
    """Source of a number."""

    what: str = Field(description="Numbers that are meant")
    source: str = Field(description="Publication that they are from")


class Model(ResponseModel):
    """A robot that scenes may name."""

    model_config = ConfigDict(title="Model")

    name: str = Field(description="Name, as `model` of a scene's robot has it")
    description: str = Field(description="Description of the robot")
    default_group: str = Field(description="The group that the bare robot name stands for")
    groups: list[Group] = Field(
        description="Groups that can be planned for, in a robot of this name"
    )
    bodies: list[str] = Field(description="Its bodies, in a robot of this name")
    sources: list[Source] = Field(description="Sources of its numbers")
    assumed: list[str] = Field(
        description="Joints whose rate limits are assumed, because no source states them"
    )

    @classmethod
    def from_summary(cls, summary: RobotSummary) -> Self:
        """Return a robot, its default group first."""
        ordered = sorted(summary.groups, key=lambda name: name != summary.default_group)
        return cls(
            name=summary.name,
            description=summary.description,
            default_group=summary.default_group,
            groups=[
                Group.from_summary(summary.groups[name], [f"{summary.name}::{name}"])
                for name in ordered
            ],
            bodies=list(summary.bodies),
            sources=[Source(what=what, source=source) for what, source in summary.sources],
            assumed=list(summary.assumed),
        )
