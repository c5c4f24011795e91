"""What failures of goals say of the nearest feasible goal, and of what would have to give way."""

from typing import Literal, NotRequired, TypedDict

from pydantic import with_config

from service.api.failures.parts import (
    OPEN,
    Bodies,
    ConstraintViolation,
    PlainPose,
    ViolatedLimit,
    ViolatingPair,
)
from service.api.models import LineStopReason


@with_config(OPEN)
class LineStopEvidence(TypedDict):
    """Place and reason of a straight line's stop."""

    reason: LineStopReason
    """Reason why the line stops"""
    fraction: float
    """Share of the line that is free [0 to 1]"""
    where: PlainPose
    """Pose of the tool there, in world"""
    positions: list[float]
    """The group's positions there [rad or m]"""
    joint: str | None
    """Joint that would leave its limits, if that is the reason"""
    pair: ViolatingPair | None
    """Pair that would violate its margin, if that is the reason"""
    singular_value: float | None
    """Least singular value of the Jacobian there"""


@with_config(OPEN)
class NearestPoseEvidence(TypedDict):
    """The feasible pose of the tool that is nearest to the goal."""

    position: list[float]
    """Position x, y, z in world [m]"""
    quaternion: list[float]
    """Rotation w, x, y, z in world"""
    positions: list[float]
    """The group's positions there [rad or m]"""
    translation_error: float
    """Distance from the goal, its tolerance aside [m]"""
    rotation_error: float
    """Angle from the goal, its tolerance aside [rad]"""
    pose_index: int
    """Index of the goal's pose that it is nearest to, from 0"""
    goal: PlainPose
    """The goal's pose, moved within its tolerance to be as near as possible"""
    binding: (
        Literal["collision", "path_constraint", "approach", "retreat", "limits", "reach"] | None
    )
    """Reason why it is not nearer; null where time ran out before that was known"""
    joints: list[str]
    """Coordinates at their limits"""
    pairs: list[Bodies]
    """Pairs of bodies at their margins"""
    constraints: list[str]
    """Path constraints that would be violated nearer to the goal"""
    line: dict[str, object] | None
    """Place and reason of a stop of its approach or retreat nearer to the goal"""
    cut_short: bool
    """Whether time ran out, so that a nearer pose may exist"""


@with_config(OPEN)
class NearestConfigurationEvidence(TypedDict):
    """The feasible configuration that is nearest to the goal's."""

    positions: list[float]
    """The group's positions [rad or m]"""
    distance: float
    """Distance from the goal's configuration, in the metric of joints [rad or m]"""
    differences: dict[str, float]
    """Difference from the goal's configuration, by coordinate [rad or m]"""
    goal_index: int
    """Index of the goal's configuration that it is nearest to, from 0"""
    binding: Literal["collision", "path_constraint", "limits"]
    """Reason why it is not nearer"""
    joints: list[str]
    """Coordinates at their limits"""
    pairs: list[Bodies]
    """Pairs of bodies at their margins"""
    constraints: list[str]
    """Path constraints that would be violated nearer to the goal"""
    cut_short: bool
    """Whether time ran out, so that a nearer one may exist"""


@with_config(OPEN)
class LargerTolerance(TypedDict):
    """Tolerances with which the nearest pose solves the goal."""

    pose_index: int
    """Index of the goal's pose, from 0"""
    position: list[float]
    """Tolerance along x, y, z of the goal [m]"""
    rotation: list[float]
    """Tolerance about x, y, z of the goal [rad]"""


@with_config(OPEN)
class PartialPose(TypedDict):
    """A configuration that keeps the rest of the pose."""

    error: float
    """Error of the position [m] or of the rotation [rad]"""
    pose_index: int
    """Index of the goal's pose, from 0"""
    positions: list[float]
    """The group's positions [rad or m]"""


@with_config(OPEN)
class RemovedBody(TypedDict):
    """A body without which the goal is feasible."""

    body: str
    """Full name of the body"""
    pose_index: int
    """Index of the goal's pose that is reached then, from 0"""
    positions: list[float]
    """The group's positions then [rad or m]"""


@with_config(OPEN)
class RelaxedConstraint(TypedDict):
    """A path constraint whose change alone is sufficient."""

    constraint: str
    """Its place in the request and its kind"""
    value: float | None
    """The bound that is sufficient, in `unit`; null where it would have to be left out"""
    bound: float | None
    """Present bound, in `unit`"""
    unit: str
    """Unit of both bounds; `1` for a number without one"""
    joint: NotRequired[str]
    """Worst joint, for constraints on joints"""

    pose_index: int
    """Index of the goal's pose that is reached then, from 0"""
    positions: list[float]
    """The group's positions then [rad or m]"""


@with_config(OPEN)
class ToolRelaxation(TypedDict):
    """Changes of a goal of the tool, each of which is sufficient."""

    tolerance: NotRequired[LargerTolerance | None]
    """Larger tolerances"""
    position: NotRequired[PartialPose | None]
    """Another position at the same rotation"""
    rotation: NotRequired[PartialPose | None]
    """Another rotation at the same position"""
    obstacles: NotRequired[list[ViolatingPair]]
    """Pairs that would have to be allowed to collide"""
    positions: NotRequired[list[float] | None]
    """The group's positions with these pairs [rad or m]"""
    cut_short: NotRequired[bool]
    """Whether time ran out, so that smaller changes may be sufficient"""
    constraints: NotRequired[list[RelaxedConstraint]]
    """Path constraints each of which would have to give way"""
    approach: NotRequired[float | None]
    """Length of an approach that is free [m]"""
    retreat: NotRequired[float | None]
    """Length of a retreat that is free [m]"""
    pose_index: NotRequired[int | None]
    """Index of the goal's pose that these lengths are for, from 0"""
    remove: NotRequired[RemovedBody | None]
    """A body to be removed"""


@with_config(OPEN)
class ConfigurationRelaxation(TypedDict):
    """All changes that the least infeasible of the goal's configurations needs."""

    goal_index: int
    """Index of the goal's configuration, from 0"""
    positions: list[float]
    """The group's positions [rad or m]"""
    limits: list[ViolatedLimit]
    """Limits that are violated"""
    obstacles: list[ViolatingPair]
    """Pairs that are violated"""
    constraints: list[ConstraintViolation]
    """Path constraints that are violated"""
    remove: list[str] | None
    """Bodies to be removed; null where the robot is in its own way"""
    margin: float | None
    """A margin that is kept [m]; null where none is"""


type Nearest = NearestPoseEvidence | NearestConfigurationEvidence | None
type Relaxation = ConfigurationRelaxation | ToolRelaxation
