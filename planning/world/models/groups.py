"""Joint groups of a robot, with their limits and named configurations."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydrake.multibody.tree import (
    PlanarJoint,
    PrismaticJoint,
    QuaternionFloatingJoint,
    RevoluteJoint,
    RpyFloatingJoint,
)

from planning.domain.robot.joints import Joint, JointGroup, JointLimits, JointType
from planning.domain.robot.steering import Steering, steered
from planning.errors import ModelInvalid, UnknownName
from planning.world.drake_model import DrakeModel
from planning.world.loading.scene_build import LoadedRobot
from planning.world.mechanics.joint_followers import is_continuous, joint_followers
from planning.world.models.default_groups import wanted_groups
from planning.world.models.model_faults import invalid
from planning.world.models.robot_card import EffortCard, LimitsCard

# Default limits: half a second to full speed, a tenth of a second to full acceleration.
_DEFAULT_VELOCITY = 1.0
ACCELERATION_PER_VELOCITY = 2.0
JERK_PER_ACCELERATION = 10.0

# Limits that joints of one coordinate alone have, and those that they do not have.
_SCALAR_RATES = ("velocity", "acceleration", "jerk")
_BLOCK_LIMITS = ("position", "linear", "angular")


@dataclass(frozen=True)
class RobotGroups:
    """Groups, configurations and warnings of one robot.

    Attributes:
        robot: Its name in the scene.
        default: Name of the group that the bare robot name stands for.
        groups: By name within the robot.
        configurations: Values by configuration and group name.
        assumed: Joints whose rate limits no source states, so that default limits are assumed.
        warnings: Parts of its SRDF that are ignored.
    """

    robot: str
    default: str
    groups: dict[str, JointGroup]
    configurations: dict[str, dict[str, tuple[float, ...]]]
    assumed: tuple[str, ...] = field(default=())
    warnings: tuple[str, ...] = ()


def robot_groups(model: DrakeModel, loaded: LoadedRobot) -> RobotGroups:
    """Return the groups of a robot: from its card, else its SRDF, else all independent joints.

    Raises:
        UnknownName: The card names a joint, in a group or with limits, a limited coordinate of
            one, or a frame that the description does not have.
        ModelInvalid: A joint has a type that planning does not support, or limits in the card
            that joints of its type do not have.
    """
    robot = loaded.scene_robot.name
    joints = _joints_of(model, loaded)
    wanted = wanted_groups(loaded, joints)
    _validate_limits(model, loaded, joints)
    steering = _steering(loaded, joints)
    groups: dict[str, JointGroup] = {}
    for name, (members, tools) in wanted.groups.items():
        for member in members:
            if member not in joints:
                raise UnknownName.among("joint", member, joints)
        chosen = tuple(joints[member] for member in members)
        full = robot if name == wanted.default else f"{robot}::{name}"
        frames = tuple(f"{robot}::{tool}" for tool in tools) or _default_tool_frames(model, chosen)
        for frame in frames:
            if frame not in model.frames:
                raise UnknownName.among("frame", frame, model.frames)
        cars = {joint.name: steering[joint.name] for joint in chosen if joint.name in steering}
        groups[name] = steered(
            JointGroup(full, chosen, frames, _winding_joints(model, chosen)), cars
        )
    warnings = tuple(f"{robot}: {text}" for text in wanted.warnings)
    return RobotGroups(
        robot, wanted.default, groups, wanted.configurations, wanted.assumed, warnings
    )


def _validate_limits(model: DrakeModel, loaded: LoadedRobot, joints: dict[str, Joint]) -> None:
    """Raise unless every limit in the card limits something that the description has."""
    prefix = f"{loaded.scene_robot.name}::"
    known = [full.removeprefix(prefix) for full in model.joint_indices if full.startswith(prefix)]
    for name, stated in (loaded.source.card.limits if loaded.source.card else {}).items():
        if name not in known:
            raise UnknownName.among("joint", name, known)
        joint = joints.get(name)  # None is a follower, of one coordinate as well
        if joint is not None and joint.type in (JointType.PLANAR, JointType.FLOATING):
            _validate_coordinates(joint, stated)
            lost = [rate for rate in _SCALAR_RATES if getattr(stated, rate) is not None]
            lost += ["effort (a number)"] if isinstance(stated.effort, float) else []
            instead = "`linear` and `angular` limits, and an effort of `force` and `torque`"
        else:
            lost = [block for block in _BLOCK_LIMITS if getattr(stated, block)]
            lost += ["effort (force, torque)"] if isinstance(stated.effort, EffortCard) else []
            instead = "`velocity`, `acceleration`, `jerk` and `effort`, and positions in its file"
        if lost:
            message = f"joint {name!r} cannot have limits of {lost[0]}: it has {instead}"
            raise ModelInvalid(message, {"joint": name, "reason": message})


def _validate_coordinates(joint: Joint, stated: LimitsCard) -> None:
    known = [name.removeprefix(f"{joint.name}.") for name in joint.position_names]
    for name in stated.position:
        if name not in known:
            raise UnknownName.among("position", name, known)


def _winding_joints(model: DrakeModel, joints: Sequence[Joint]) -> tuple[str, ...]:
    """Return the revolute joints whose whole turns move their followers."""
    return tuple(
        joint.name
        for joint in joints
        if joint.type is JointType.REVOLUTE
        and any(follower.is_moved_by_whole_turns for follower in joint_followers(model, joint.name))
    )


def group_limits(model: DrakeModel, group: JointGroup, robots: list[LoadedRobot]) -> JointLimits:
    """Return a group's own limits: the card's where it states them, else the description's.

    Followers of the group have limits as well (`followers`).
    """
    by_robot = {loaded.scene_robot.name: loaded for loaded in robots}
    lower: list[float] = []
    upper: list[float] = []
    rates: list[tuple[float, float, float, float]] = []
    for joint in group.joints:
        robot, _, name = joint.name.partition("::")
        card = by_robot[robot].source.card
        stated = card.limits.get(name, LimitsCard()) if card else LimitsCard()
        drake_joint = model.plant.get_joint(model.joint_indices[joint.name])
        low, high = _position_bounds(joint, stated, drake_joint)
        lower += low
        upper += high
        if joint.type in (JointType.PLANAR, JointType.FLOATING):
            rates += _block_rates(joint, stated)
        else:
            effort = by_robot[robot].file.effort.get(name, np.inf)
            rates.append(_scalar_rates(stated, drake_joint, effort))
    velocity, acceleration, jerk, effort = np.array(rates).T
    return JointLimits(
        lower=np.array(lower),
        upper=np.array(upper),
        velocity=velocity,
        acceleration=acceleration,
        jerk=jerk,
        effort=effort,
        blocks=tuple(indices for _, indices in group.blocks),
    )


def _steering(loaded: LoadedRobot, joints: dict[str, Joint]) -> dict[str, Steering]:
    """Return the card's steering of joints, by full name.

    Raises:
        ModelInvalid: One of them is not planar.
    """
    card = loaded.source.card
    found: dict[str, Steering] = {}
    for name, stated in (card.limits if card else {}).items():
        if stated.steering is None:
            continue
        if name not in joints or joints[name].type is not JointType.PLANAR:
            message = f"joint {name!r} is not planar, so it cannot be steered"
            raise ModelInvalid(message, {"joint": name, "reason": message})
        car = stated.steering
        found[joints[name].name] = Steering(car.turning_radius, car.reverse)
    return found


def _joints_of(model: DrakeModel, loaded: LoadedRobot) -> dict[str, Joint]:
    """Return the robot's independent joints, in Drake's order."""
    followers = {mimic.follower for mimic in loaded.file.mimics}
    joints: dict[str, Joint] = {}
    prefix = f"{loaded.scene_robot.name}::"
    for full in model.joint_indices:
        name = full.removeprefix(prefix)
        if full.startswith(prefix) and name not in followers:
            joints[name] = Joint(full, _type_of(model, full, loaded))
    return joints


def _type_of(model: DrakeModel, name: str, loaded: LoadedRobot) -> JointType:
    joint = model.plant.get_joint(model.joint_indices[name])
    match joint:
        case RevoluteJoint():
            return JointType.CONTINUOUS if is_continuous(model, name) else JointType.REVOLUTE
        case PrismaticJoint():
            return JointType.PRISMATIC
        case PlanarJoint():
            return JointType.PLANAR
        case QuaternionFloatingJoint():
            return JointType.FLOATING
        case RpyFloatingJoint() | _:
            kinds = sorted(kind.value for kind in JointType)
            reason = f"joint {name!r} has type {joint.type_name()!r}; supported types: {kinds}"
            raise invalid(loaded.file.file, reason, joint=name)


def _default_tool_frames(model: DrakeModel, joints: tuple[Joint, ...]) -> tuple[str, ...]:
    """Return the frame of the last link that the last joint carries: the default tool frame."""
    if not joints:
        return ()
    last = model.plant.get_joint(model.joint_indices[joints[-1].name]).child_body()
    carried = model.plant.GetBodiesWeldedTo(last)
    names = [model.body_names[body.index()] for body in carried if body.index() in model.body_names]
    names = [name for name in names if name not in model.owners]  # an attached object is no tool
    return (max(names, key=lambda name: int(model.bodies[name])),)


def _position_bounds(
    joint: Joint, stated: LimitsCard, drake_joint: Any
) -> tuple[list[float], list[float]]:
    lower = [float(bound) for bound in drake_joint.position_lower_limits()]
    upper = [float(bound) for bound in drake_joint.position_upper_limits()]
    for i, name in enumerate(joint.position_names):
        bounds = stated.position.get(name.removeprefix(f"{joint.name}."))
        if bounds is not None:
            lower[i], upper[i] = bounds
    return lower, upper


def _scalar_rates(
    stated: LimitsCard, joint: Any, effort: float
) -> tuple[float, float, float, float]:
    velocity_limit = float(joint.velocity_upper_limits()[0])
    velocity_limit = (
        velocity_limit if np.isfinite(velocity_limit) and velocity_limit > 0 else _DEFAULT_VELOCITY
    )
    velocity = stated.velocity or velocity_limit
    acceleration = stated.acceleration or velocity * ACCELERATION_PER_VELOCITY
    jerk = stated.jerk or acceleration * JERK_PER_ACCELERATION
    if isinstance(stated.effort, float):
        effort = stated.effort
    return velocity, acceleration, jerk, effort if effort > 0 else np.inf


def _block_rates(joint: Joint, stated: LimitsCard) -> list[tuple[float, float, float, float]]:
    rates: list[tuple[float, float, float, float]] = []
    for name, _ in joint.blocks:
        is_linear = name.endswith(".linear")
        card = stated.linear if is_linear else stated.angular
        effort = np.inf
        if isinstance(stated.effort, EffortCard):
            effort = stated.effort.force if is_linear else stated.effort.torque
        v = card.velocity if card else _DEFAULT_VELOCITY
        a = card.acceleration if card else v * ACCELERATION_PER_VELOCITY
        rates.append((v, a, card.jerk if card else a * JERK_PER_ACCELERATION, effort))
    return rates
