"""SceneGroups: groups of a scene's robots and those that span them, with their configurations."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.spanning_group import joined_name, member_names, spanning_group
from planning.domain.scene.scene import NamedGroup, Scene
from planning.errors import ProblemInvalid, SceneInvalid, UnknownName
from planning.world.models.groups import RobotGroups

type Configurations = Mapping[str, Mapping[str, Array]]

# Groups that requests spell out as `left+right` are kept, so that caches by group find them.
_MAX_JOINED = 64


class SceneGroups:
    """Groups by name: those of robots, those of the scene document, and joined ones.

    Attributes:
        own: Groups of the robots, each once, in the order of the robots.
        spanning: Groups that the scene names, and those that its configurations name.
    """

    def __init__(self, scene: Scene, robots: Sequence[RobotGroups]) -> None:
        """Resolve the scene's groups.

        Raises:
            SceneInvalid: A member does not exist, two members have a joint in common, or a group
                has the name of a robot; evidence has its `path`.
        """
        self.own = tuple(group for robot in robots for group in robot.groups.values())
        self._own = {group.name: group for group in self.own}
        for robot in robots:
            for name, group in robot.groups.items():
                self._own.setdefault(f"{robot.robot}::{name}", group)
        self._by_name = dict(self._own)
        self._members: dict[str, tuple[str, ...]] = {name: (name,) for name in self._own}
        self._joined: dict[str, JointGroup] = {}
        names = {robot.robot for robot in robots}
        spanning = [self._named(entry, names) for entry in scene.groups]
        for entry in scene.configurations:
            path = f"configurations.{entry.name}.group"
            group = _of_scene(path, partial(self.find, entry.group))
            if group.name not in self._by_name:
                self._by_name[group.name] = group
                self._members[group.name] = member_names(group.name)
                spanning.append(group)
        self.spanning = tuple(spanning)

    def find(self, name: str) -> JointGroup:
        """Return a group by `robot`, `robot::group`, its own name, or several joined by `+`.

        Raises:
            UnknownName: There is none.
            ProblemInvalid: Two of the joined groups have a joint in common.
        """
        if name in self._by_name:
            return self._by_name[name]
        members: list[JointGroup] = []
        for part in member_names(name):
            if part not in self._by_name:
                raise UnknownName.among("group", part, self._by_name)
            members.append(self._by_name[part])
        return self._join(members)

    def members(self, group: JointGroup) -> tuple[str, ...]:
        """Return the names of the robots' groups that a group spans; its own for one of these."""
        return self._members.get(group.name) or member_names(group.name)

    def configurations(self, group: JointGroup, own: Configurations) -> dict[str, Array]:
        """Return a group's named configurations, each shape (nq,).

        A spanning group has each that all its members have by that name, and those that the scene
        states for a group of the same members.

        Args:
            group: The group.
            own: Configurations by group and name, as the robots' cards and the scene state them.
        """
        members = self.members(group)
        if len(members) == 1 and group.name in self._own:
            return dict(own.get(group.name, {}))
        first, *others = (own.get(member, {}) for member in members)
        found = {
            name: np.concatenate([q, *(other[name] for other in others)])
            for name, q in first.items()
            if all(name in other for other in others)
        }
        for stated in self.spanning:
            if self.members(stated) == members:
                found.update(own.get(stated.name, {}))
        return found

    def _named(self, entry: NamedGroup, robots: set[str]) -> JointGroup:
        """Return a group of the scene document, and keep it by its name."""
        path = f"groups.{entry.name}"
        if entry.name in robots:
            message = f"{path}: {entry.name!r} is a robot, and means its default group"
            raise SceneInvalid(message, {"path": path})
        members: list[JointGroup] = []
        for i, name in enumerate(entry.members):
            members.append(_of_scene(f"{path}.{i}", partial(self._robot_group, name)))
        group = _of_scene(path, partial(spanning_group, entry.name, members))
        self._by_name[group.name] = group
        self._members[group.name] = names = tuple(member.name for member in members)
        # What is joined from the same members is this group.
        self._by_name.setdefault(joined_name(names), group)
        return group

    def _robot_group(self, name: str) -> JointGroup:
        if name not in self._own:
            raise UnknownName.among("group", name, self._own)
        return self._own[name]

    def _join(self, members: Sequence[JointGroup]) -> JointGroup:
        """Return the group that spans some groups, the same one for the same members."""
        names = tuple(name for member in members for name in self.members(member))
        full = joined_name(names)
        known = self._by_name.get(full) or self._joined.get(full)
        if known is None:
            if len(self._joined) >= _MAX_JOINED:
                self._joined.clear()
            known = self._joined[full] = spanning_group(full, [self._own[name] for name in names])
        return known


def _of_scene[T](path: str, find: Callable[[], T]) -> T:
    """Return what is found; errors become errors of the scene, with their path."""
    try:
        return find()
    except (UnknownName, ProblemInvalid) as fault:
        raise SceneInvalid(f"{path}: {fault.detail}", {**fault.evidence, "path": path}) from fault
