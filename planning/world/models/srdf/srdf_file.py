"""SRDF (MoveIt): groups, named configurations and end effectors from the file beside a URDF."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as ET

from planning.world.documents.xml_file import xml_root
from planning.world.models.srdf.srdf_groups import SrdfGroups, Tree
from planning.world.models.srdf.srdf_warnings import Fault, srdf_warnings, unknown

# Number of parts that are not read with a warning each.
_MAX_WARNINGS = 20


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
        warnings: Parts of the file that are not read as they stand.
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
    reader = SrdfGroups(root, _tree(urdf))
    groups = _groups(reader, movable)
    faults: list[Fault] = []
    configurations: dict[str, dict[str, tuple[float, ...]]] = {}
    for state in root.findall("group_state"):
        name, group = state.get("name", ""), state.get("group", "")
        try:
            configurations.setdefault(name, {})[group] = _values(state, groups, movable)
        except _StateIgnored as fault:
            faults.append((f"group state {name!r} of {group!r}", f" is ignored: {fault}"))
    read = {name: group.joints for name, group in groups.items()}
    faults += srdf_warnings(root, reader, read, movable)
    return Srdf(groups, configurations, _texts(file.name, faults))


def _texts(file: str, faults: list[Fault]) -> tuple[str, ...]:
    """Return the warnings of a file, each once, not too many."""
    distinct = list(dict.fromkeys(faults))
    shown = [f"{subject} in {file}{text}" for subject, text in distinct[:_MAX_WARNINGS]]
    if len(distinct) > _MAX_WARNINGS:
        shown.append(f"{len(distinct) - _MAX_WARNINGS} more parts of {file} are not read")
    return tuple(shown)


def _groups(reader: SrdfGroups, movable: Mapping[str, int]) -> dict[str, SrdfGroup]:
    found: dict[str, SrdfGroup] = {}
    for name in reader.ordered:
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
    reader = SrdfGroups(xml_root(file.read_bytes()), _tree(urdf))
    return {joint for name in reader.end_effector_groups for joint in reader.members(name)}


class _StateIgnored(Exception):
    """Reason why a group state is ignored."""


def _values(
    state: ET.Element, groups: Mapping[str, SrdfGroup], movable: Mapping[str, int]
) -> tuple[float, ...]:
    name = state.get("group", "")
    group = groups.get(name)
    if group is None:
        fault = unknown("group", name, groups)
        raise _StateIgnored(f"there is no such group with moving joints: {fault}")
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


def _srdf_file(urdf: Path) -> Path | None:
    srdf = urdf.with_suffix(".srdf")
    return srdf if urdf.suffix.lower() == ".urdf" and srdf.is_file() else None


def _tree(urdf: Path) -> Tree:
    return Tree.of(xml_root(urdf.read_bytes()))
