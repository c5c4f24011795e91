"""What a request asks of a scene that the scene does not have, by its summary alone.

It is refused before anything is queued. Which fields name something, their types say
(`service/api/names.py`): this is the one place where names are looked up, and positions counted.
"""

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Protocol

from planning.domain.robot.spanning_group import common_joint, member_names
from planning.errors import ModelInvalid, ProblemInvalid, UnknownName
from service.api.models import COORDINATES, JoinedNames
from service.api.names import Mention, mentions
from service.errors import WrongCount
from service.scenes.models.summary import Group
from service.scenes.store.records import SceneRecord

_MAX_ERRORS = 20


class GroupRequest(Protocol):
    """A request about a group of a scene."""

    @property
    def group(self) -> str:
        """Its name."""
        ...


def check_request(scene: SceneRecord, request: GroupRequest) -> Group:
    """Return the group that a request is about; it names only what the scene and the group have.

    Raises:
        UnknownName: It names something else; evidence: `errors` has all such names.
        WrongCount: A list of positions does not fit the group.
        ModelInvalid: The group is a robot's, none of whose joints moves.
    """
    group = find_group(scene, request.group)
    found = list(mentions(request))
    # Only those that are looked up: a scene may have thousands of bodies.
    kinds = {one.kind for one in found if one.kind in _NAMES}
    known = {kind: _NAMES[kind](scene, group) for kind in kinds}
    unknown = [one for one in found if one.kind in known and one.value not in known[one.kind]]
    if unknown:
        raise _unknown_names(unknown, known)
    for one in found:
        if one.kind == COORDINATES:
            _check_count(group, one)
    return group


def find_group(scene: SceneRecord, name: str) -> Group:
    """Return a group of a scene: one that it has, or one that spans several, joined by `+`.

    Raises:
        UnknownName: The scene has none of that name; evidence: `errors` has all such names.
        ModelInvalid: It is a robot's, none of whose joints moves.
        ProblemInvalid: Two of the joined groups have a joint in common.
    """
    groups, by_name = scene.summary.groups, _by_name(scene)
    names = _members(name, by_name)
    wrong: list[Mention] = []
    for i, member in enumerate(names):
        known = by_name.get(member)
        robots = (robot["name"] for robot in scene.document["robots"])
        if (known is not None and not known.joints) or (known is None and member in robots):
            raise _immobile(member, scene)
        if known is None:
            steps = ("group", i) if isinstance(name, JoinedNames) else ("group",)
            wrong.append(Mention(steps, "group", member))
    if wrong:
        raise _unknown_names(wrong, {"group": [group.name for group in groups]})
    return _joined([by_name[member] for member in names], by_name)


def joined_group(scene: SceneRecord, names: Sequence[str], field: str = "group") -> Group:
    """Return the group that spans some groups; raises as `find_group`, of the given field."""
    try:
        return _joined([find_group(scene, name) for name in names], _by_name(scene))
    except ProblemInvalid as fault:
        raise ProblemInvalid(fault.detail, {**fault.evidence, "field": field}) from fault


def _by_name(scene: SceneRecord) -> dict[str, Group]:
    groups = scene.summary.groups
    return {alias: group for group in groups for alias in (*group.aliases, group.name)}


def _members(name: str, known: Collection[str]) -> tuple[str, ...]:
    """Return the names of the groups that a name joins; it is the only one if it is known."""
    if isinstance(name, JoinedNames):
        return name.members
    return (name,) if name in known else member_names(name)


def _joined(groups: Sequence[Group], by_name: Mapping[str, Group]) -> Group:
    """Return the group that spans some groups.

    Raises:
        ProblemInvalid: Two of them have a joint in common.
    """
    if len(groups) == 1:
        return groups[0]
    own = [by_name[name] for group in groups for name in group.members or [group.name]]
    counts = Counter(joint.name for group in own for joint in group.joints)
    joint, count = counts.most_common(1)[0]
    if count > 1:
        raise common_joint(
            joint, [g.name for g in groups if joint in {one.name for one in g.joints}]
        )
    whole = Group.spanning(own)
    return by_name.get(whole.name, whole)


def _immobile(name: str, scene: SceneRecord) -> ModelInvalid:
    robot = name.partition("::")[0]
    models = {entry["name"]: entry["model"] for entry in scene.document["robots"]}
    reason = "no joint of it moves, so there is nothing to plan for: it can only be an obstacle"
    evidence = {"file": models.get(robot, ""), "reason": reason, "robot": robot}
    return ModelInvalid(f"robot {robot!r}: {reason}", evidence)


def _joints(_: SceneRecord, group: Group) -> dict[str, str]:
    return {joint.name: joint.type for joint in group.joints}


def _mobile_joints(_: SceneRecord, group: Group) -> list[str]:
    return [joint.name for joint in group.joints if joint.type in {"planar", "floating"}]


# What a scene and a group have, by the kinds of names that a request about the group may mention.
# As dictionaries: of thousands of objects none is compared with each name.
_NAMES: Mapping[str, Callable[[SceneRecord, Group], Collection[str]]] = {
    "body": lambda scene, _: dict.fromkeys(scene.summary.bodies),
    "configuration": lambda _, group: group.configurations,
    "frame": lambda scene, _: dict.fromkeys(scene.summary.frames),
    "joint": _joints,
    "joint or block": lambda scene, group: dict.fromkeys([
        *_joints(scene, group),
        *group.limits.blocks,
    ]),
    "planar or floating joint": _mobile_joints,
    "position": lambda _, group: group.position_names,
}


def _unknown_names(wrong: Sequence[Mention], known: Mapping[str, Collection[str]]) -> UnknownName:
    """Return the error for names that do not exist; it says most of the first one."""
    faults = [
        UnknownName.among(one.kind, one.value, known[one.kind]) for one in wrong[:_MAX_ERRORS]
    ]
    errors = [
        one.error(fault.evidence["nearest"]) for one, fault in zip(wrong, faults, strict=False)
    ]
    more = f" (and {len(wrong) - 1} more unknown names)" if len(wrong) > 1 else ""
    return UnknownName(f"{faults[0].detail}{more}", {**faults[0].evidence, "errors": errors})


def _check_count(group: Group, positions: Mention) -> None:
    """Raise unless there is one number for each position coordinate of the group."""
    names, count = group.position_names, len(positions.value)
    if count != len(names):
        field = positions.path
        message = f"{field}: {group.name} has {len(names)} positions, got {count}"
        evidence = {"field": field, "expected": len(names), "got": count, "names": names}
        error = {"pointer": positions.pointer, "message": message, "nearest": []}
        raise WrongCount(message, {**evidence, "errors": [error]})
