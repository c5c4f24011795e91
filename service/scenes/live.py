"""Live state: where the robots of a scene are, whatever its document says.

It is the latest revision's own state, and on top of it what executions have measured since. What
is set by hand is part of a revision, and replaces what was measured of that robot before.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from enum import StrEnum
from typing import Any

from planning.domain.robot.joints import Joint, JointType
from service.scenes.models.summary import Group

# Of a joint: a number, or several where it has several coordinates [rad or m].
type Coordinates = float | list[float]
# Of a robot, by the joint's name within it.
type JointPositions = Mapping[str, Coordinates]


class RobotStatus(StrEnum):
    """Whether a robot moves."""

    AT_REST = "at_rest"
    MOVING = "moving"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class DocumentSource:
    """The document of a revision says where a robot is."""

    revision: int


@dataclass(frozen=True)
class EditSource:
    """Positions were set by hand; the revision is the one that came of it."""

    revision: int


@dataclass(frozen=True)
class ExecutionSource:
    """An execution has measured where a robot is."""

    execution: str


type Source = DocumentSource | EditSource | ExecutionSource


@dataclass(frozen=True)
class KeptState:
    """What is stored of a robot: what executions have measured since it was set by hand.

    Attributes:
        robot: Its name.
        positions: Of the joints that were measured; none if it was set by hand since.
        status: At rest, or unknown.
        source: Of the positions.
        updated_at: When the execution ended, or the revision was made (UTC).
        ended: The last execution whose end it knows of.
    """

    robot: str
    positions: JointPositions
    status: RobotStatus
    source: Source
    updated_at: datetime
    ended: str | None


@dataclass(frozen=True)
class Motion:
    """An execution that has not ended, and what it has measured so far.

    Attributes:
        execution: Its id.
        group: That it moves.
        sequence: Of its job.
        robots: That it moves or will move.
        joints: Types of the group's joints, by full name.
        updated_at: When it was last heard of (UTC).
        positions: Measured, by robot and joint; None before it began.
        velocities: Measured [rad/s or m/s], by robot and joint, as far as they are known.
        number: Of the event that said so; 0 before there was one.
        held: Objects that are held by contact, as measured (JSON).
    """

    execution: str
    group: str
    sequence: int
    robots: Sequence[str]
    joints: Mapping[str, JointType]
    updated_at: datetime
    positions: Mapping[str, JointPositions] | None = None
    velocities: Mapping[str, JointPositions] | None = None
    number: int = 0
    held: Sequence[Mapping[str, Any]] = ()


@dataclass(frozen=True)
class RobotState:
    """Where a robot is.

    Attributes:
        robot: Its name.
        positions: Of all joints of its groups.
        velocities: As far as they are known [rad/s or m/s].
        status: Whether it moves.
        source: Of the positions.
        updated_at: When they were last told (UTC).
        ended: The last execution whose end is known of.
        execution: That moves it, or waits to.
        held: Objects that it holds by contact, as measured while it moves (JSON).
    """

    robot: str
    positions: JointPositions
    velocities: JointPositions | None
    status: RobotStatus
    source: Source
    updated_at: datetime
    ended: str | None = None
    execution: str | None = None
    held: Sequence[Mapping[str, Any]] = ()


def live_states(
    described: Mapping[str, JointPositions],
    document: tuple[int, datetime],
    kept: Iterable[KeptState],
    motions: Iterable[Motion],
) -> dict[str, RobotState]:
    """Return where the robots of a scene are, by name.

    Args:
        described: Where the latest revision has them.
        document: That revision, and when it was made (UTC).
        kept: What was measured and set by hand.
        motions: Executions that have not ended.
    """
    revision, made_at = document
    told_of = {each.robot: each for each in kept}
    states: dict[str, RobotState] = {}
    for robot, positions in described.items():
        at_first = KeptState(
            robot, {}, RobotStatus.AT_REST, DocumentSource(revision), made_at, None
        )
        told = told_of.get(robot, at_first)
        states[robot] = RobotState(
            robot,
            {**positions, **told.positions},
            None,
            told.status,
            told.source,
            told.updated_at,
            told.ended,
        )
    for motion in sorted(motions, key=lambda each: each.sequence):
        for robot in motion.robots:
            if robot in states:
                states[robot] = moved_by(motion, states[robot])
    return states


def moved_by(motion: Motion, state: RobotState) -> RobotState:
    """Return where a robot is once a motion has told it; one that has ended since tells nothing."""
    if motion.execution == state.ended:
        return state
    found = replace(state, execution=state.execution or motion.execution)
    if motion.positions is None:
        return found
    return replace(
        found,
        positions={**state.positions, **motion.positions.get(state.robot, {})},
        velocities=(motion.velocities or {}).get(state.robot),
        status=RobotStatus.MOVING,
        source=ExecutionSource(motion.execution),
        updated_at=motion.updated_at,
        held=motion.held,
    )


def joint_types(group: Group) -> dict[str, JointType]:
    """Return the types of a group's joints by full name, in the group's order."""
    return {joint.name: JointType(joint.type) for joint in group.joints}


def by_joint(
    joints: Mapping[str, JointType], values: Sequence[float], *, are_velocities: bool = False
) -> dict[str, dict[str, Coordinates]]:
    """Return the positions of a group, or its velocities, by robot and joint.

    Args:
        joints: Their types, by full name.
        values: In that order.
        are_velocities: Whether they are velocities: of a floating joint these are fewer.
    """
    found: dict[str, dict[str, Coordinates]] = {}
    at = 0
    for name, kind in joints.items():
        joint = Joint(name, kind)
        size = len(joint.velocity_names if are_velocities else joint.position_names)
        robot, _, own_name = name.partition("::")
        own = list(values[at : at + size])
        found.setdefault(robot, {})[own_name] = own[0] if size == 1 else own
        at += size
    return found


def described_positions(groups: Sequence[Group]) -> dict[str, dict[str, Coordinates]]:
    """Return where a scene's document has its robots, by robot and joint."""
    found: dict[str, dict[str, Coordinates]] = {}
    for group in groups:
        for robot, joints in by_joint(joint_types(group), group.positions).items():
            found.setdefault(robot, {}).update(joints)
    return found


def posed(groups: Sequence[Group], positions: Mapping[str, JointPositions]) -> list[Group]:
    """Return groups whose positions are those of a live state, by robot and joint."""
    return [_posed(group, positions) if positions else group for group in groups]


def _posed(group: Group, positions: Mapping[str, JointPositions]) -> Group:
    values: list[float] = []
    for robot, joints in _in_order(group):
        told = positions.get(robot, {})
        for name, described in joints.items():
            found = told.get(name, described)
            values += found if isinstance(found, list) else [found]
    return group.model_copy(update={"positions": values})


def _in_order(group: Group) -> Iterable[tuple[str, dict[str, Coordinates]]]:
    """Yield each joint of a group by itself, as `by_joint` has it."""
    at = 0
    for name, kind in joint_types(group).items():
        size = len(Joint(name, kind).position_names)
        yield from by_joint({name: kind}, group.positions[at : at + size]).items()
        at += size
