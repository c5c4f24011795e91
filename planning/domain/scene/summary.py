"""Summaries of scenes and robots: groups, limits, configurations, frames and bodies as values."""

from dataclasses import dataclass, field

from planning.domain.geometry.unchecked_pair import UncheckedPair
from planning.domain.robot.gripper import Gripper
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class GroupSummary(Value):
    """Group with its limits, configurations and positions.

    Attributes:
        group: Its joints and tool frames.
        limits: Its joint limits.
        configurations: Named configurations, the group's q.
        positions: Its positions in the scene, the group's q.
        members: Groups of robots that it spans; empty for one of these.
        gripper: The gripper that it is, or None.
    """

    group: JointGroup
    limits: JointLimits
    configurations: dict[str, tuple[float, ...]]
    positions: tuple[float, ...]
    members: tuple[str, ...] = ()
    gripper: Gripper | None = None


@dataclass(frozen=True, eq=False)
class RobotSummary(Value):
    """Robot model that scenes may use.

    Attributes:
        name: Its name.
        description: For people.
        groups: By name within the robot; bodies and joints are named `robot::name`.
        default_group: Name of the group that the bare robot name stands for.
        bodies: Full names.
        sources: Sources of its numbers, as (what, from).
        assumed: Joints whose rate limits no source states, so that default limits are assumed.
    """

    name: str
    description: str
    groups: dict[str, GroupSummary]
    default_group: str
    bodies: tuple[str, ...]
    sources: tuple[tuple[str, str], ...] = ()
    assumed: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class SceneSummary(Value):
    """Summary of a loaded scene.

    Attributes:
        groups: By full name, `robot` or `robot::group`; then those that span several, by theirs.
        frames: Full names of all frames, "world" included.
        bodies: Full names of all bodies.
        num_pairs: Pairs of geometries that are checked for collision.
        digest: sha256 of the scene.
        assumed: Joints whose rate limits no source states, so that default limits are assumed.
        unchecked: Pairs of bodies that no collision check covers, with reasons.
        warnings: Approximations and likely mistakes, such as meshes taken as their convex hulls.
    """

    groups: dict[str, GroupSummary]
    frames: tuple[str, ...]
    bodies: tuple[str, ...]
    num_pairs: int
    digest: str
    assumed: tuple[str, ...] = ()
    unchecked: tuple[UncheckedPair, ...] = ()
    warnings: tuple[str, ...] = field(default=())
