"""Spanning groups: joint groups that are made of several others, such as two arms.

A spanning group's q and v stack those of its members, in the order in which they are given. It has
a name of its own, or that of its members joined by `+`: `left+right`, `left::arm+lift`.
"""

from collections import Counter
from collections.abc import Sequence

from planning.domain.robot.joints import JointGroup
from planning.domain.robot.steering import Steering, steered, steering_of
from planning.errors import ProblemInvalid

_SEPARATOR = "+"


def joined_name(members: Sequence[str]) -> str:
    """Return the name of the group that spans some groups; of one group it is its own."""
    return _SEPARATOR.join(members)


def member_names(name: str) -> tuple[str, ...]:
    """Return the names that are joined in a group's name; of most names it is the only one."""
    return tuple(name.split(_SEPARATOR))


def spanning_group(name: str, members: Sequence[JointGroup]) -> JointGroup:
    """Return the group that spans some groups: their joints and tool frames, in this order.

    Args:
        name: Its name.
        members: At least one; no two have a joint in common.

    Raises:
        ProblemInvalid: Two members have a joint in common; evidence: `joint`, `groups`.
    """
    validate_disjoint([member.name for member in members], members)
    steering: dict[str, Steering] = {}
    for member in members:
        steering.update(steering_of(member))
    group = JointGroup(
        name,
        tuple(joint for member in members for joint in member.joints),
        tuple(dict.fromkeys(frame for member in members for frame in member.tool_frames)),
        tuple(joint for member in members for joint in member.winding),
    )
    return steered(group, steering)


def validate_disjoint(names: Sequence[str], groups: Sequence[JointGroup]) -> None:
    """Raise if two groups have a joint in common.

    Args:
        names: Of the groups, for the message.
        groups: Groups that shall move together.

    Raises:
        ProblemInvalid: A joint is in two groups; evidence: `joint`, `groups`.
    """
    counts = Counter(joint.name for group in groups for joint in group.joints)
    for joint, count in counts.items():
        if count == 1:
            continue
        owners = [
            name
            for name, group in zip(names, groups, strict=True)
            if any(own.name == joint for own in group.joints)
        ]
        raise common_joint(joint, owners)


def common_joint(joint: str, groups: Sequence[str]) -> ProblemInvalid:
    """Return the error of groups that shall move together and have a joint in common."""
    message = (
        f"joint {joint!r} is in several of the groups {list(groups)}: groups that move together "
        "have no joint in common"
    )
    return ProblemInvalid(message, {"field": "group", "joint": joint, "groups": list(groups)})
