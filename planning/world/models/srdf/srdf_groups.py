"""SrdfGroups: groups of an SRDF, resolved to joints and tool frames."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from xml.etree import ElementTree as ET


@dataclass(frozen=True)
class Tree:
    """Names in a URDF.

    Attributes:
        links: Links, in order.
        joints: All joints, fixed ones too, in order.
        parents: Joint and parent link of every link that has them.
    """

    links: tuple[str, ...]
    joints: tuple[str, ...]
    parents: Mapping[str, tuple[str, str]]

    @classmethod
    def of(cls, root: ET.Element) -> "Tree":
        """Read the root element of a URDF."""
        parents: dict[str, tuple[str, str]] = {}
        joints = root.findall("joint")
        for joint in joints:
            parent, child = joint.find("parent"), joint.find("child")
            if parent is not None and child is not None:
                parents[child.get("link", "")] = (joint.get("name", ""), parent.get("link", ""))
        links = tuple(link.get("name", "") for link in root.findall("link"))
        return cls(links, tuple(joint.get("name", "") for joint in joints), parents)

    def ancestors(self, link: str) -> list[str]:
        """Return the links above a link, nearest first."""
        found: list[str] = []
        while link in self.parents:
            link = self.parents[link][1]
            if link in found:
                break
            found.append(link)
        return found

    def chain_joints(self, base: str, tip: str) -> list[str]:
        """Return the joints from a link to a descendant; from the root if it has no such base."""
        members: list[str] = []
        link = tip
        while link in self.parents and link != base:
            joint, link = self.parents[link]
            if joint in members:
                break
            members.insert(0, joint)
        return members


class SrdfGroups:
    """Resolver of the groups in an SRDF.

    Attributes:
        elements: The groups by name; of several with one name, the last.
        tree: Names in the URDF.
        effectors: End effectors.
        end_effector_groups: Names of the groups that are end effectors.
        world_frames: Frames that a virtual joint carries the root link in.
    """

    def __init__(self, root: ET.Element, tree: Tree) -> None:
        """Take the root elements of an SRDF and the names in its URDF."""
        self.elements = {group.get("name", ""): group for group in root.findall("group")}
        self.tree = tree
        self.effectors = root.findall("end_effector")
        named = {effector.get("group", "") for effector in self.effectors}
        self.end_effector_groups = [name for name in self.elements if name in named]
        self.world_frames = {
            joint.get("parent_frame", "") for joint in root.findall("virtual_joint")
        }

    @cached_property
    def ordered(self) -> Sequence[str]:
        """Names of the groups, the default one first."""

        def rank(name: str) -> tuple[bool, bool, bool]:
            group = self.elements[name]
            has_chain, has_groups = group.find("chain") is not None, group.find("group") is not None
            return name in self.end_effector_groups, not has_chain, has_groups

        return sorted(self.elements, key=rank)

    def is_chain(self, name: str) -> bool:
        """Return whether a group is one chain and nothing else, so that it has an order."""
        return [part.tag for part in self.elements[name]] == ["chain"]

    def members(self, name: str, enclosing: frozenset[str] = frozenset()) -> list[str]:
        """Return the joints of a group: of its chains, joints, links and subgroups."""
        found: list[str] = []
        if name not in self.elements or name in enclosing:
            return found
        for part in self.elements[name]:
            own = part.get("name", "")
            match part.tag:
                case "chain":
                    found += self._chain_joints(part)
                case "joint":
                    found.append(own)
                case "link" if own in self.tree.parents:
                    found.append(self.tree.parents[own][0])
                case "group":
                    found += self.members(own, enclosing | {name})
                case _:
                    pass
        return found

    def tools(self, name: str, joints: Sequence[str]) -> tuple[str, ...]:
        """Return the tips of a group's chains and the parent links of its end effectors."""
        tips = [
            chain.get("tip_link", "")
            for chain in self.elements[name].findall("chain")
            if self.is_readable(chain)
        ]
        for effector in () if name in self.end_effector_groups else self.effectors:
            link, of = effector.get("parent_link", ""), effector.get("parent_group")
            if of == name or (of is None and self._is_moved(link, joints)):
                tips.append(link)
        return tuple(tip for tip in dict.fromkeys(tips) if tip in self.tree.links)

    def _is_moved(self, link: str, joints: Sequence[str]) -> bool:
        """Return whether a group's last joint carries a link, directly or by fixed joints."""
        return bool(joints) and joints[-1] in self.tree.chain_joints("", link)

    def is_readable(self, chain: ET.Element) -> bool:
        """Return whether a chain's base is above its tip."""
        base, tip = chain.get("base_link", ""), chain.get("tip_link", "")
        return base in self.tree.ancestors(tip) or (
            base in self.world_frames and base not in self.tree.links and tip in self.tree.links
        )

    def _chain_joints(self, chain: ET.Element) -> list[str]:
        """Return the joints of a chain that is readable, from its base on."""
        base, tip = chain.get("base_link", ""), chain.get("tip_link", "")
        return self.tree.chain_joints(base, tip) if self.is_readable(chain) else []
