"""Groups from the SRDF beside a URDF (MoveIt's semantic description)."""

from pathlib import Path

from planning.world.xml_file import xml_root


def read_srdf_groups(urdf: Path, movable: list[str]) -> dict[str, tuple[list[str], list[str]]]:
    """Return joints and tool frames by group, chains first; empty without an SRDF.

    Args:
        urdf: A description that was inspected already.
        movable: Names of the joints that move by themselves, in order.
    """
    srdf = urdf.with_suffix(".srdf")
    if urdf.suffix.lower() != ".urdf" or not srdf.is_file():
        return {}
    parents = _parent_joints(urdf)
    chains: dict[str, tuple[list[str], list[str]]] = {}
    others: dict[str, tuple[list[str], list[str]]] = {}
    for group in xml_root(srdf.read_bytes()).findall("group"):
        name = group.get("name", "")
        chain = group.find("chain")
        if chain is not None:
            base, tip = chain.get("base_link", ""), chain.get("tip_link", "")
            members = _joints_between(parents, base, tip)
            chains[name] = ([joint for joint in members if joint in movable], [tip])
        else:
            named = {joint.get("name", "") for joint in group.findall("joint")}
            others[name] = ([joint for joint in movable if joint in named], [])
    found = {**chains, **others}
    return {name: group for name, group in found.items() if group[0]}


def _parent_joints(urdf: Path) -> dict[str, tuple[str, str]]:
    """Return (joint, parent link) of every link."""
    parents: dict[str, tuple[str, str]] = {}
    for joint in xml_root(urdf.read_bytes()).findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            parents[child.get("link", "")] = (joint.get("name", ""), parent.get("link", ""))
    return parents


def _joints_between(parents: dict[str, tuple[str, str]], base: str, tip: str) -> list[str]:
    members: list[str] = []
    link = tip
    while link in parents and link != base:
        joint, link = parents[link]
        members.insert(0, joint)
    return members
