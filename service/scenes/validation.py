"""Preflight: what a scene cannot do is refused before anything is queued, by its summary alone."""

from collections.abc import Iterable, Sequence

from planning.domain.request.motion_limits import missing_effort_limits, validate_signed_blocks
from planning.domain.robot.joints import Joint, JointType
from planning.errors import ModelInvalid, UnknownName
from service.errors import WrongCount
from service.plans.models.constraints import (
    Constraint,
    DistanceBand,
    JointLimits,
    KeepIn,
    KeepOut,
    LockedJoints,
    Orientation,
    Position,
)
from service.plans.models.goals import (
    ConfigurationGoal,
    Goal,
    JointGoal,
    PoseGoal,
    RegionGoal,
    RelativeGoal,
)
from service.plans.models.line_goals import LineGoal, PathGoal
from service.plans.models.motion_limits import MotionLimits
from service.scenes.models.summary import Group
from service.scenes.records import SceneRecord


def require_group(scene: SceneRecord, name: str) -> Group:
    """Return the summary of a group.

    Raises:
        UnknownName: The scene has none of that name.
        ModelInvalid: It is a robot's, none of whose joints moves.
    """
    groups = scene.summary.groups
    for group in groups:
        if name == group.name or name in group.aliases:
            if not group.joints:
                raise _still(name, scene)
            return group
    if name in (robot["name"] for robot in scene.document["robots"]):
        raise _still(name, scene)
    raise UnknownName.among("group", name, [group.name for group in groups])


def _still(name: str, scene: SceneRecord) -> ModelInvalid:
    robot = name.partition("::")[0]
    models = {entry["name"]: entry["model"] for entry in scene.document["robots"]}
    reason = "no joint of it moves, so there is nothing to plan for: it can only be an obstacle"
    evidence = {"file": models.get(robot, ""), "reason": reason, "robot": robot}
    return ModelInvalid(f"robot {robot!r}: {reason}", evidence)


def joints_of(group: Group) -> list[Joint]:
    """Return a group's joints as the domain has them."""
    return [Joint(joint.name, JointType(joint.type)) for joint in group.joints]


def require_frames(scene: SceneRecord, names: Sequence[str]) -> None:
    """Go on only if the scene has all these frames.

    Raises:
        UnknownName: It does not.
    """
    frames = scene.summary.frames
    for name in names:
        if name not in frames:
            raise UnknownName.among("frame", name, frames)


def require_count(group: Group, positions: Sequence[float], field: str) -> None:
    """Go on only if there is one number per position coordinate of the group.

    Raises:
        WrongCount: There is not.
    """
    names: list[str] = group.position_names
    if len(positions) != len(names):
        message = f"{field}: {group.name} has {len(names)} positions, got {len(positions)}"
        evidence = {"field": field, "expected": len(names), "got": len(positions), "names": names}
        raise WrongCount(message, evidence)


def require_goal(scene: SceneRecord, group: Group, goal: Goal) -> None:
    """Go on only if the goal can be meant in this scene.

    Raises:
        UnknownName: A frame or configuration does not exist.
        WrongCount: A list of positions does not fit the group.
    """
    match goal:
        case JointGoal():
            for q in rows(goal.positions):
                require_count(group, q, "goal.positions")
        case ConfigurationGoal():
            if goal.name not in group.configurations:
                raise UnknownName.among("configuration", goal.name, group.configurations)
        case _:
            require_frames(scene, frames_of(goal))


def frames_of(
    goal: PoseGoal | RegionGoal | RelativeGoal | LineGoal | PathGoal,
) -> list[str]:
    """Return the frames that a goal names."""
    match goal:
        case RelativeGoal():
            named = [goal.reference]
        case RegionGoal():
            named = [pose.frame for pose in goal.poses or [goal.pose] if pose is not None]
        case PoseGoal():
            named = [pose.frame for pose in goal.poses] + [goal.metric and goal.metric.frame]
        case LineGoal():
            named = [end.frame for end in (goal.pose, goal.displacement) if end is not None]
        case PathGoal():
            named = [pose.frame for pose in goal.poses]
    return [name for name in [goal.frame, *named] if name is not None]


def require_joints(group: Group, names: Iterable[str]) -> None:
    """Go on only if the group has all these joints.

    Raises:
        UnknownName: It does not.
    """
    known: list[str] = [joint.name for joint in group.joints]
    for name in names:
        if name not in known:
            raise UnknownName.among("joint", name, known)


def rows(positions: Sequence[float] | Sequence[Sequence[float]]) -> list[list[float]]:
    """Return one list of positions, or several, as several."""
    several = [list(row) for row in positions if not isinstance(row, int | float)]
    return several or [[float(x) for x in positions if isinstance(x, int | float)]]


def require_constraints(
    scene: SceneRecord, group: Group, constraints: Sequence[Constraint]
) -> None:
    """Go on only if the path constraints name what the scene has.

    Raises:
        UnknownName: A frame, body, joint or coordinate does not exist.
    """
    for constraint in constraints:
        match constraint:
            case DistanceBand():
                names = [*(constraint.bodies or []), *(constraint.to or [])]
                _require("body", names, scene.summary.bodies)
            case KeepOut() | KeepIn():
                require_frames(scene, [constraint.frame, constraint.box.pose.frame])
            case Position():
                require_frames(scene, [constraint.frame, constraint.pose.frame])
            case Orientation():
                require_frames(scene, [constraint.frame, constraint.reference])
            case LockedJoints():
                joints = [joint.name for joint in group.joints]
                _require("joint", constraint.joints, joints)
            case JointLimits():
                _require("joint", list(constraint.limits), group.position_names)


def _require(kind: str, names: Sequence[str], known: Sequence[str]) -> None:
    for name in names:
        if name not in known:
            raise UnknownName.among(kind, name, known)


def require_motion_limits(scene: SceneRecord, group: Group, limits: MotionLimits) -> None:
    """Go on only if the limits name what the scene has.

    Raises:
        UnknownName: A frame or joint does not exist, or has several coordinates.
        ProblemInvalid: Efforts shall be kept, and no joint of the group has a limit on them.
    """
    if limits.effort and all(bound is None for bound in group.limits.effort):
        raise missing_effort_limits(group.name)
    require_frames(scene, [limit.frame for limit in limits.tool_limits])
    for zone in limits.speed_zones:
        require_frames(scene, [zone.frame, zone.box.pose.frame])
    if limits.payload is not None:
        require_frames(scene, [limits.payload.frame])
    validate_signed_blocks(limits.acceleration_bounds, joints_of(group))
