"""wanted_groups(): groups of a robot from its card, else from its SRDF, else one of all joints."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from planning.domain.robot.joints import Joint
from planning.world.loading.scene_build import LoadedRobot
from planning.world.models.robot_card import RobotCard
from planning.world.models.srdf.srdf_file import read_srdf


@dataclass(frozen=True)
class WantedGroups:
    """Groups of a robot by names of joints and frames.

    Attributes:
        default: Name of the group that the bare robot name stands for.
        groups: Joints and tool frames, by name; no tool frames mean the group's last link.
        configurations: Values by configuration and group.
        assumed: Joints whose rate limits are not stated.
        warnings: Parts of the files that are ignored.
    """

    default: str
    groups: dict[str, tuple[Sequence[str], Sequence[str]]]
    configurations: dict[str, dict[str, tuple[float, ...]]]
    assumed: tuple[str, ...]
    warnings: tuple[str, ...] = ()


def wanted_groups(loaded: LoadedRobot, joints: Mapping[str, Joint]) -> WantedGroups:
    """Return the groups of a robot's card; without one, its SRDF's and one of all joints.

    Args:
        loaded: The robot.
        joints: Its independent joints, by their names in the description.
    """
    card = loaded.source.card
    return _card_groups(card, joints) if card else _srdf_groups(loaded, joints)


def _card_groups(card: RobotCard, joints: Mapping[str, Joint]) -> WantedGroups:
    return WantedGroups(
        default=card.default_group,
        groups={name: (group.joints, group.tool_frames) for name, group in card.groups.items()},
        configurations={
            name: {group: tuple(q) for group, q in by_group.items()}
            for name, by_group in card.configurations.items()
        },
        assumed=tuple(name for name in joints if name not in card.limits),
    )


def _srdf_groups(loaded: LoadedRobot, joints: Mapping[str, Joint]) -> WantedGroups:
    """Return the groups of the SRDF, if there is one, and one of all joints that move."""
    counts = {name: len(joint.position_names) for name, joint in joints.items()}
    srdf = read_srdf(loaded.file.file, counts)
    groups: dict[str, tuple[Sequence[str], Sequence[str]]] = {
        name: (group.joints, group.tool_frames) for name, group in srdf.groups.items()
    }
    if joints:
        groups.setdefault("all", (list(joints), ()))
    return WantedGroups(
        default=next(iter(groups), ""),
        groups=groups,
        configurations={name: dict(by_group) for name, by_group in srdf.configurations.items()},
        assumed=tuple(joints),
        warnings=srdf.warnings,
    )
