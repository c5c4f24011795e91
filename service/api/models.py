"""Bases and shared parts of what goes over HTTP as JSON: numbers, poses.

Numbers are finite, never text, never booleans; 1.0 is an integer, as JSON has it.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    AllowInfNan,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    Strict,
    StringConstraints,
    model_validator,
)

from planning.domain.geometry import pose as domain
from planning.domain.goals.goal import PoseTarget
from planning.domain.request.options import MIN_SCALE
from planning.domain.robot.spanning_group import joined_name

if TYPE_CHECKING:
    import numpy as np


def integral(number: Any) -> Any:
    """Turn 3.0 into 3: JSON knows one kind of number."""
    is_whole = isinstance(number, float) and number.is_integer()
    return int(number) if is_whole else number


# Last in an `Annotated`, so that bounds before it stay bounds of the number.
WHOLE = BeforeValidator(integral)

type Integer = Annotated[int, Strict(), WHOLE]
type Real = Annotated[float, Strict(), AllowInfNan(allow_inf_nan=False)]
type Coordinate = Annotated[
    float, Strict(), AllowInfNan(allow_inf_nan=False), Field(ge=-1e6, le=1e6)
]
type NonNegative = Annotated[float, Strict(), AllowInfNan(allow_inf_nan=False), Field(ge=0, le=1e6)]
type Scale = Annotated[float, Strict(), AllowInfNan(allow_inf_nan=False), Field(ge=MIN_SCALE, le=1)]
type Triple = Annotated[list[Coordinate], Field(min_length=3, max_length=3)]
type Quadruple = Annotated[list[Coordinate], Field(min_length=4, max_length=4)]
type Interval = Annotated[list[Coordinate], Field(min_length=2, max_length=2)]
type Positions = Annotated[list[Coordinate], Field(min_length=1, max_length=256)]
type Name = Annotated[str, StringConstraints(min_length=1, max_length=256)]
type Identifier = Annotated[str, StringConstraints(min_length=1, max_length=128)]
# Named, so that a generated client has one type of each.
type Timings = Annotated[dict[str, float], Field(description="Seconds by stage [s]")]
type Versions = Annotated[
    dict[str, str], Field(description="Versions of everything that the numbers depend on, by name")
]
type LineLeg = Annotated[
    Literal["approach", "retreat"], Field(description="Straight line to a goal, or away from it")
]
type LineStopReason = Annotated[
    Literal["limit", "singularity", "collision", "unreachable"],
    Field(description="Reason why a straight line stops"),
]
type SampleRejection = Annotated[
    Literal[
        "not_converged", "outside_limits", "collision", "path_constraint", "approach", "duplicate"
    ],
    Field(description="Test that an IK sample fails"),
]
# "no" and 0 are refused: some clients mean false by them, and JSON has a word for it.
type Boolean = Annotated[bool, Strict()]


class JoinedNames(str):
    """Name of a group that spans several, which were given as a list: their names, joined."""

    __slots__ = ("members",)

    members: tuple[str, ...]

    @classmethod
    def of(cls, names: str | list[str]) -> str:
        """Return the one name of a group or of a list of groups."""
        if isinstance(names, str):
            return names
        joined = cls(joined_name(names))
        joined.members = tuple(names)
        return joined


GROUP = (
    "`robot` for its default group, `robot::group`, or a group that the scene names; a list of "
    "several, or their names joined by `+`, for one group of all their joints, in this order"
)
if TYPE_CHECKING:
    GroupName = str
else:
    GroupName = Annotated[
        Annotated[str, StringConstraints(min_length=1, max_length=1024)]
        | Annotated[list[Name], Field(min_length=1, max_length=32)],
        AfterValidator(JoinedNames.of),
    ]


@dataclass(frozen=True)
class Mark:
    """Mark of a type: its values name a part of a scene, or have a number for each coordinate.

    `service/api/names.py` finds them in requests.

    Attributes:
        kind: Of the part, as errors call it; `COORDINATES` for one number per coordinate.
    """

    kind: str


COORDINATES = "coordinates of the group"

BodyName = Annotated[Name, Mark("body")]
ConfigurationName = Annotated[Name, Mark("configuration")]
FrameName = Annotated[Name, Mark("frame")]
JointName = Annotated[Name, Mark("joint")]
JointOrBlockName = Annotated[Name, Mark("joint or block")]
MobileJointName = Annotated[Name, Mark("planar or floating joint")]
PositionName = Annotated[Name, Mark("position")]
GroupPositions = Annotated[Positions, Mark(COORDINATES)]

PRIORITY = (
    "Priority among the jobs that wait; clients take turns within it. A job that has "
    "waited for 30 s goes with the next priority: `low` is delayed by others, never for "
    "good"
)
UNRECORDED = (
    "Facts that the database does not hold yet, because it is full, locked or away: "
    "`cancel`, `controls`, `events`, `end`. They are written as soon as possible; "
    "requests are carried out all the same"
)


ATTEMPTS = (
    "Number of times that a worker has begun with it, this one included; more than 1 "
    "where a worker or the server ended under it"
)
CANCEL_REQUESTED_AT = (
    "Time of the first request to end it (UTC), whatever came of it; null if there was "
    "none, or if the version did not record it"
)


class RequestModel(BaseModel):
    """What is asked: a JSON object with no unknown fields."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class ResponseModel(BaseModel):
    """What is answered: clients must expect fields that are added later.

    It can be made from an object of the domain that has its fields as attributes.
    """

    model_config = ConfigDict(extra="ignore", frozen=True, from_attributes=True)


def require_one_rotation(quaternion: list[float] | None, rpy: list[float] | None) -> None:
    """Go on only if a rotation is given once, or not at all, and is one.

    Raises:
        ValueError: It is not.
    """
    if quaternion is not None and rpy is not None:
        message = "give `quaternion` or `rpy`, not both"
        raise ValueError(message)
    if quaternion is not None and not math.hypot(*quaternion) > 1e-9:
        message = "quaternion [w, x, y, z] must not be zero"
        raise ValueError(message)


class Pose(RequestModel):
    """A rigid transform in a frame; `quaternion` or `rpy`, or neither for no rotation."""

    model_config = ConfigDict(
        title="Pose",
        json_schema_extra={
            "examples": [
                {"position": [0.4, 0.2, 0.3], "quaternion": [0, 1, 0, 0], "frame": "world"}
            ]
        },
    )

    position: Triple = Field(description="x, y, z in `frame` [m]")
    quaternion: Quadruple | None = Field(
        default=None, description="Rotation as [w, x, y, z]; normalised when read, never zero"
    )
    rpy: Triple | None = Field(
        default=None, description="Rotation as roll, pitch, yaw about fixed x, y, z [rad]"
    )
    frame: FrameName = Field(
        default="world", description="The frame that the pose is given in: any frame of the scene"
    )

    @model_validator(mode="after")
    def _one_rotation(self) -> Self:
        require_one_rotation(self.quaternion, self.rpy)
        return self

    @classmethod
    def from_domain(cls, pose: domain.Pose) -> Self:
        """Return the model of a pose in world."""
        return cls(position=pose.position.tolist(), quaternion=pose.quaternion.tolist())

    def to_domain(self) -> domain.Pose:
        """Return the transform, without the frame that it is given in."""
        return domain.Pose.from_parts(self.position, self.quaternion, self.rpy)

    def to_target(self) -> PoseTarget:
        """Return the transform with the frame that it is given in."""
        return PoseTarget(self.to_domain(), self.frame)


def listed(array: "np.ndarray[Any, Any]") -> list[Any]:
    """Return an array as nested lists of floats."""
    nested: list[Any] = array.astype(float).tolist()
    return nested


def finite(number: float) -> float | None:
    """Return the number, or None if JSON cannot hold it."""
    return float(number) if math.isfinite(number) else None


def bounds(numbers: Iterable[float]) -> list[float | None]:
    """Return numbers with None for those that bound nothing."""
    return [finite(number) for number in numbers]
