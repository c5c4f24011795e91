"""Initial positions of a scene's robots, and its named configurations."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.domain.scene.scene import NamedConfiguration, Scene, SceneRobot
from planning.errors import ProblemInvalid, SceneInvalid, UnknownName
from planning.world.drake_model import DrakeModel
from planning.world.loading.positions import validate_positions
from planning.world.loading.scene_build import LoadedRobot
from planning.world.models.groups import RobotGroups
from planning.world.models.mimic_limits import combined_limits

type Configurations = dict[str, dict[str, Array]]


def named_configurations(
    scene: Scene, robots: Sequence[RobotGroups], find_group: Callable[[str], JointGroup]
) -> Configurations:
    """Return the robots' and the scene's named configurations, by group.

    Raises:
        UnknownName: A robot's card names a group that it does not have.
        SceneInvalid: The scene does, or a count is wrong.
    """
    collected: Configurations = {group.name: {} for own in robots for group in own.groups.values()}
    for own in robots:
        for name, by_group in own.configurations.items():
            for group_name, q in by_group.items():
                if group_name not in own.groups:
                    raise UnknownName.among("group", group_name, own.groups)
                group = own.groups[group_name]
                path = f"{own.robot}, configuration {name}"
                collected[group.name][name] = _validated_positions(group, q, path)
    for entry in scene.configurations:
        group = _group_of(entry, find_group)
        q = _validated_positions(group, entry.positions, f"configurations.{entry.name}.positions")
        collected.setdefault(group.name, {})[entry.name] = q
    return collected


def initial_state(
    model: DrakeModel,
    robots: Sequence[LoadedRobot],
    groups: Sequence[RobotGroups],
    configurations: Configurations,
    nominal: Array,
) -> Array:
    """Return the scene's current configuration of all joints, shape (num_positions,).

    A robot starts at its configuration `home`, if it has one, else at Drake's nominal positions
    within its limits; the scene's own positions override both.

    Raises:
        SceneInvalid: The scene names a joint or configuration that does not exist, or a count is
            wrong.
    """
    state = np.array(nominal)
    for i, (loaded, own) in enumerate(zip(robots, groups, strict=True)):
        positions = _robot_positions(
            loaded.scene_robot, own, configurations, f"robots.{i}.positions"
        )
        for group in reversed(own.groups.values()):
            indices = model.position_indices(group)
            limits = combined_limits(model, group, robots)
            clipped = np.clip(state[indices], limits.lower, limits.upper)
            state[indices] = positions.get(group.name, clipped)
        for name, q in positions.items():
            group = next(group for group in own.groups.values() if group.name == name)
            state[model.position_indices(group)] = q
        if isinstance(loaded.scene_robot.positions, dict):
            _place_joints(model, state, loaded.scene_robot, f"robots.{i}.positions")
    return model.apply_couplings(state)


def _robot_positions(
    robot: SceneRobot, own: RobotGroups, configurations: Configurations, path: str
) -> dict[str, Array]:
    """Return the scene's positions of a robot's groups, by full group name."""
    home = _positions_in_configuration(own, configurations, "home")
    match robot.positions:
        case str() as name:
            chosen = _positions_in_configuration(own, configurations, name)
            if not chosen:
                known = {n for g in own.groups.values() for n in configurations[g.name]}
                fault = UnknownName.among("configuration", name, known)
                raise SceneInvalid(f"{path}: {fault.detail}", {"path": path, **fault.evidence})
            return {**home, **chosen}
        case tuple() as numbers:
            if own.default not in own.groups:
                message = f"{path}: {robot.name!r} has no joint that moves"
                raise SceneInvalid(message, {"path": path})
            group = own.groups[own.default]
            return {**home, group.name: _validated_positions(group, numbers, path)}
        case _:
            return home


def _positions_in_configuration(
    own: RobotGroups, configurations: Configurations, name: str
) -> dict[str, Array]:
    return {
        group.name: configurations[group.name][name]
        for group in own.groups.values()
        if name in configurations[group.name]
    }


def _place_joints(model: DrakeModel, state: Array, robot: SceneRobot, path: str) -> None:
    """Set the joints for which the scene gives single values."""
    assert isinstance(robot.positions, dict)  # noqa: S101  (the caller's case)
    for name, number in robot.positions.items():
        full = f"{robot.name}::{name.removeprefix(f'{robot.name}::')}"
        if full not in model.joint_indices:
            known = [n for n in model.joint_indices if n.startswith(f"{robot.name}::")]
            fault = UnknownName.among("joint", full, known)
            where = f"{path}.{name}"
            raise SceneInvalid(f"{where}: {fault.detail}", {"path": where, **fault.evidence})
        joint = model.plant.get_joint(model.joint_indices[full])
        values = np.atleast_1d(np.array(number, dtype=np.float64))
        if len(values) != joint.num_positions():
            count = joint.num_positions()
            message = f"{path}.{name}: {full} has {count} positions, got {len(values)}"
            raise SceneInvalid(message, {"path": f"{path}.{name}"})
        begin = joint.position_start()
        state[begin : begin + len(values)] = values


def _group_of(entry: NamedConfiguration, find_group: Callable[[str], JointGroup]) -> JointGroup:
    path = f"configurations.{entry.name}.group"
    try:
        return find_group(entry.group)
    except UnknownName as fault:
        message = f"{path}: {fault.detail}"
        raise SceneInvalid(message, {"path": path, **fault.evidence}) from fault


def _validated_positions(group: JointGroup, q: Any, path: str) -> Array:
    """Return q validated as the group's positions; errors become errors of the scene."""
    try:
        return validate_positions(group, q, path)
    except ProblemInvalid as fault:
        raise SceneInvalid(fault.detail, {**fault.evidence, "path": path}) from fault
