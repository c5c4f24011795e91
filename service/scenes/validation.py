"""What a request asks of a scene that the scene does not have, by its summary alone.

It is refused before anything is queued. Which fields name something, their types say
(`service/api/names.py`): this is the one place where names are looked up, and positions counted.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import Protocol

from planning.errors import ModelInvalid, UnknownName
from service.api.models import COORDINATES
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
    known = _known_names(scene, group)
    found = list(mentions(request))
    unknown = [one for one in found if one.kind in known and one.value not in known[one.kind]]
    if unknown:
        raise _unknown_names(unknown, known)
    for one in found:
        if one.kind == COORDINATES:
            _check_count(group, one)
    return group


def find_group(scene: SceneRecord, name: str) -> Group:
    """Return a group of a scene.

    Raises:
        UnknownName: The scene has none of that name.
        ModelInvalid: It is a robot's, none of whose joints moves.
    """
    groups = scene.summary.groups
    for group in groups:
        if name == group.name or name in group.aliases:
            if not group.joints:
                raise _immobile(name, scene)
            return group
    if name in (robot["name"] for robot in scene.document["robots"]):
        raise _immobile(name, scene)
    wrong = Mention(("group",), "group", name)
    raise _unknown_names([wrong], {"group": [group.name for group in groups]})


def _immobile(name: str, scene: SceneRecord) -> ModelInvalid:
    robot = name.partition("::")[0]
    models = {entry["name"]: entry["model"] for entry in scene.document["robots"]}
    reason = "no joint of it moves, so there is nothing to plan for: it can only be an obstacle"
    evidence = {"file": models.get(robot, ""), "reason": reason, "robot": robot}
    return ModelInvalid(f"robot {robot!r}: {reason}", evidence)


def _known_names(scene: SceneRecord, group: Group) -> Mapping[str, Collection[str]]:
    """Return the names of each kind that a request about a group may mention."""
    joints = {joint.name: joint.type for joint in group.joints}
    # As dictionaries: of thousands of objects none is compared with each name.
    return {
        "body": dict.fromkeys(scene.summary.bodies),
        "configuration": group.configurations,
        "frame": dict.fromkeys(scene.summary.frames),
        "joint": joints,
        "joint or block": dict.fromkeys([*joints, *group.limits.blocks]),
        "planar or floating joint": [
            name for name, kind in joints.items() if kind in {"planar", "floating"}
        ],
        "position": group.position_names,
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
