"""SRDF (MoveIt): groups, named configurations and end effectors from the file beside a URDF."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as ET

from planning.world.documents.xml_file import xml_root


@dataclass(frozen=True)
class SrdfGroup:
    """Group of an SRDF.

    Attributes:
        joints: Independent joints, from the base on.
        tool_frames: Links at the tips of its chains, then parent links of end effectors.
    """

    joints: tuple[str, ...]
    tool_frames: tuple[str, ...]


@dataclass(frozen=True)
class Srdf:
    """Content of an SRDF; all empty where there is none.

    Attributes:
        groups: By name, the default one first: chains before others, end effectors last.
        configurations: Values by configuration and group, in the group's order.
        warnings: Parts of the file that are ignored.
    """

    groups: Mapping[str, SrdfGroup] = field(default_factory=dict)
    configurations: Mapping[str, Mapping[str, tuple[float, ...]]] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


def read_srdf(urdf: Path, movable: Mapping[str, int]) -> Srdf:
    """Return the content of the SRDF of the same name beside a URDF.

    Args:
        urdf: A description that was inspected already, and its SRDF with it.
        movable: Number of positions of each independent joint, in order.
    """
    file = _srdf_file(urdf)
    if file is None:
        return Srdf()
    root = xml_root(file.read_bytes())
    groups = _groups(_Reader(root, _parent_joints(urdf)), movable)
    warnings: list[str] = []
    configurations: dict[str, dict[str, tuple[float, ...]]] = {}
    for state in root.findall("group_state"):
        name, group = state.get("name", ""), state.get("group", "")
        try:
            configurations.setdefault(name, {})[group] = _values(state, groups, movable)
        except _StateIgnored as fault:
            text = f"group state {name!r} of {group!r} in {file.name} is ignored: {fault}"
            warnings.append(text)
    warnings += [
        f"virtual joint {joint.get('name', '')!r} in {file.name} has type {joint.get('type')!r} "
        "and is ignored: the base link is welded to the world"
        for joint in root.findall("virtual_joint")
        if joint.get("type") != "fixed"
    ]
    return Srdf(groups, configurations, tuple(warnings))


def _groups(reader: "_Reader", movable: Mapping[str, int]) -> dict[str, SrdfGroup]:
    found: dict[str, SrdfGroup] = {}
    for name in reader.ordered():
        members = reader.members(name)
        joints = members if reader.is_chain(name) else [j for j in movable if j in members]
        joints = [joint for joint in joints if joint in movable]
        if joints:
            found[name] = SrdfGroup(tuple(joints), reader.tools(name, joints))
    return found


def end_effector_joints(urdf: Path) -> set[str]:
    """Return the joints of the groups that an SRDF beside a URDF declares end effectors."""
    file = _srdf_file(urdf)
    if file is None:
        return set()
    reader = _Reader(xml_root(file.read_bytes()), _parent_joints(urdf))
    return {joint for name in reader.end_effector_groups for joint in reader.members(name)}


class _StateIgnored(Exception):
    """Reason why a group state is ignored."""


def _values(
    state: ET.Element, groups: Mapping[str, SrdfGroup], movable: Mapping[str, int]
) -> tuple[float, ...]:
    group = groups.get(state.get("group", ""))
    if group is None:
        raise _StateIgnored("there is no such group with moving joints")
    values_by_joint = {
        joint.get("name", ""): joint.get("value", "") for joint in state.findall("joint")
    }
    values: list[float] = []
    for joint in group.joints:
        if joint not in values_by_joint:
            raise _StateIgnored(f"it has no value for joint {joint!r}")
        try:
            numbers = [float(word) for word in values_by_joint[joint].split()]
        except ValueError:
            numbers = []
        if len(numbers) != movable[joint] or not all(map(math.isfinite, numbers)):
            expected = f"{movable[joint]} finite number" + "s" * (movable[joint] > 1)
            raise _StateIgnored(f"joint {joint!r} needs {expected}, got {values_by_joint[joint]!r}")
        values += numbers
    return tuple(values)


class _Reader:
    """Resolver of the names in an SRDF."""

    def __init__(self, root: ET.Element, parents: dict[str, tuple[str, str]]) -> None:
        self._groups = {group.get("name", ""): group for group in root.findall("group")}
        self._parents = parents
        self._effectors = root.findall("end_effector")
        named = {effector.get("group", "") for effector in self._effectors}
        self.end_effector_groups = [name for name in self._groups if name in named]

    def ordered(self) -> list[str]:
        """Return the names of the groups, the default one first."""

        def rank(name: str) -> tuple[bool, bool, bool]:
            group = self._groups[name]
            has_chain, has_groups = group.find("chain") is not None, group.find("group") is not None
            return name in self.end_effector_groups, not has_chain, has_groups

        return sorted(self._groups, key=rank)

    def is_chain(self, name: str) -> bool:
        """Return whether a group is one chain and nothing else, so that it has an order."""
        return [part.tag for part in self._groups[name]] == ["chain"]

    def members(self, name: str, enclosing: frozenset[str] = frozenset()) -> list[str]:
        """Return the joints of a group: of its chains, joints, links and subgroups."""
        found: list[str] = []
        if name not in self._groups or name in enclosing:
            return found
        for part in self._groups[name]:
            own = part.get("name", "")
            match part.tag:
                case "chain":
                    found += self._chain_joints(part.get("base_link", ""), part.get("tip_link", ""))
                case "joint":
                    found.append(own)
                case "link" if own in self._parents:
                    found.append(self._parents[own][0])
                case "group":
                    found += self.members(own, enclosing | {name})
                case _:
                    pass
        return found

    def tools(self, name: str, joints: list[str]) -> tuple[str, ...]:
        """Return the tips of a group's chains and the parent links of its end effectors."""
        tips = [chain.get("tip_link", "") for chain in self._groups[name].findall("chain")]
        for effector in () if name in self.end_effector_groups else self._effectors:
            link, of = effector.get("parent_link", ""), effector.get("parent_group")
            if of == name or (of is None and self._is_moved(link, joints)):
                tips.append(link)
        return tuple(dict.fromkeys(tips))

    def _is_moved(self, link: str, joints: list[str]) -> bool:
        """Return whether a group's last joint carries a link, directly or by fixed joints."""
        return bool(joints) and joints[-1] in self._chain_joints("", link)

    def _chain_joints(self, base: str, tip: str) -> list[str]:
        """Return the joints from a link to a descendant; without a base, all ancestors' joints."""
        members: list[str] = []
        link = tip
        while link in self._parents and link != base:
            joint, link = self._parents[link]
            if joint in members:
                break
            members.insert(0, joint)
        return members


def _srdf_file(urdf: Path) -> Path | None:
    srdf = urdf.with_suffix(".srdf")
    return srdf if urdf.suffix.lower() == ".urdf" and srdf.is_file() else None


def _parent_joints(urdf: Path) -> dict[str, tuple[str, str]]:
    """Return (joint, parent link) of every link."""
    parents: dict[str, tuple[str, str]] = {}
    for joint in xml_root(urdf.read_bytes()).findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            parents[child.get("link", "")] = (joint.get("name", ""), parent.get("link", ""))
    return parents
