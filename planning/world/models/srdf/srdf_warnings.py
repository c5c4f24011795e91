"""srdf_warnings(): what of an SRDF is not read, with the name that was probably meant."""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from difflib import get_close_matches
from xml.etree import ElementTree as ET

from planning.world.models.srdf.srdf_groups import SrdfGroups

_READ = (
    "disable_collisions",
    "end_effector",
    "group",
    "group_state",
    "passive_joint",
    "virtual_joint",
)
# Number of names in a warning where none is near.
_MAX_KNOWN = 10

# What a warning is about, and what is said of it.
type Fault = tuple[str, str]


def srdf_warnings(
    root: ET.Element,
    groups: SrdfGroups,
    read: Mapping[str, Collection[str]],
    movable: Collection[str],
) -> Iterator[Fault]:
    """Yield every part of an SRDF that is not read as it stands.

    Args:
        root: Root element of the SRDF.
        groups: Its groups, resolved in its URDF.
        read: Independent joints of the groups that are read, by name.
        movable: Independent joints of the robot.
    """
    yield from _group_warnings(root, groups, read)
    for effector in groups.effectors:
        yield from _effector_warnings(groups, effector)
    yield from _state_warnings(root, groups, read)
    yield from _pair_warnings(root, groups)
    yield from _joint_warnings(root, groups, movable)
    for tag, count in Counter(part.tag for part in root if part.tag not in _READ).items():
        yield f"<{tag}>", f" is not read ({count} of them)"


def unknown(kind: str, name: str, known: Collection[str]) -> str:
    """Return the text about a name that does not exist: the nearest that does, else the first."""
    folded = {other.casefold(): other for other in known}
    nearest = get_close_matches(name.casefold(), folded, n=1)
    some = list(known)[:_MAX_KNOWN]
    hint = f"did you mean {folded[nearest[0]]!r}?" if nearest else f"there are {some}"
    more = "" if nearest or len(known) <= _MAX_KNOWN else f" and {len(known) - _MAX_KNOWN} more"
    return f"{kind} {name!r} does not exist; {hint}{more}"


def _group_warnings(
    root: ET.Element, groups: SrdfGroups, read: Mapping[str, Collection[str]]
) -> Iterator[Fault]:
    for name, count in Counter(group.get("name", "") for group in root.findall("group")).items():
        if count > 1:
            yield f"group {name!r}", f" is given {count} times: the last one is read"
    for name, group in groups.elements.items():
        for part in group:
            fault = _part_fault(groups, part)
            if fault:
                yield f"group {name!r}", f": {fault}"
        if name not in read:
            yield f"group {name!r}", " is left out: no joint of it moves by itself"


def _part_fault(groups: SrdfGroups, part: ET.Element) -> str:
    """Return what is wrong with a part of a group; empty if nothing is."""
    name, tree = part.get("name", ""), groups.tree
    match part.tag:
        case "joint":
            return "" if name in tree.joints else unknown("joint", name, tree.joints)
        case "link":
            return "" if name in tree.links else unknown("link", name, tree.links)
        case "group":
            return "" if name in groups.elements else unknown("group", name, groups.elements)
        case "chain":
            fault = _chain_fault(groups, part)
            return fault and f"a chain is left out: {fault}"
        case _:
            return f"<{part.tag}> is not read: a group has chains, joints, links and groups"


def _chain_fault(groups: SrdfGroups, chain: ET.Element) -> str:
    base, tip, tree = chain.get("base_link", ""), chain.get("tip_link", ""), groups.tree
    if tip not in tree.links:
        return unknown("tip_link", tip, tree.links)
    if groups.is_readable(chain):
        return ""
    if base not in tree.links:
        return unknown("base_link", base, tree.links)
    if tip in tree.ancestors(base):
        return f"it is reversed: exchange base_link {base!r} and tip_link {tip!r}"
    return f"base_link {base!r} is not above tip_link {tip!r}; links above: {tree.ancestors(tip)}"


def _effector_warnings(groups: SrdfGroups, effector: ET.Element) -> Iterator[Fault]:
    for field, kind, known in (
        ("parent_link", "link", groups.tree.links),
        ("group", "group", groups.elements),
        ("parent_group", "group", groups.elements),
    ):
        name = effector.get(field)
        if name is None and field == "parent_group":
            continue  # it may be left out
        if name not in known:
            fault = unknown(kind, name or "", known)
            yield f"end effector {effector.get('name', '')!r}", f": {field}: {fault}"


def _state_warnings(
    root: ET.Element, groups: SrdfGroups, read: Mapping[str, Collection[str]]
) -> Iterator[Fault]:
    states = root.findall("group_state")
    keys = Counter((state.get("name", ""), state.get("group", "")) for state in states)
    for (name, group), count in keys.items():
        if count > 1:
            subject = f"group state {name!r} of {group!r}"
            yield subject, f" is given {count} times: the last one is read"
    for state in states:
        group = state.get("group", "")
        if group not in read:
            continue  # all of it is ignored, which is told
        # Values of followers and of fixed joints follow from others.
        known = {*groups.members(group), *read[group]}
        for joint in (part.get("name", "") for part in state.findall("joint")):
            if joint not in known:
                fault = unknown(f"in group {group!r} joint", joint, read[group])
                yield f"group state {state.get('name', '')!r}", f": a value is ignored: {fault}"


def _pair_warnings(root: ET.Element, groups: SrdfGroups) -> Iterator[Fault]:
    links = Counter(
        pair.get(side, "")
        for pair in root.findall("disable_collisions")
        for side in ("link1", "link2")
    )
    for link, count in links.items():
        if link not in groups.tree.links:
            pairs = "a pair is" if count == 1 else f"{count} pairs are"
            fault = unknown("link", link, groups.tree.links)
            yield "disable_collisions", f": {pairs} ignored: {fault}"


def _joint_warnings(
    root: ET.Element, groups: SrdfGroups, movable: Collection[str]
) -> Iterator[Fault]:
    for joint in root.findall("virtual_joint"):
        if joint.get("type") != "fixed":
            text = f" has type {joint.get('type')!r} and is ignored: the base link is welded to "
            yield f"virtual joint {joint.get('name', '')!r}", text + "the world"
    for name in (joint.get("name", "") for joint in root.findall("passive_joint")):
        if name not in groups.tree.joints:
            yield "passive_joint", f": {unknown('joint', name, groups.tree.joints)}"
        elif name in movable:
            yield f"passive joint {name!r}", " is not read: it is planned for like the others"
