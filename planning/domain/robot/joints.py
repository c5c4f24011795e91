"""Joints, joint groups and joint limits."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Indices
from planning.domain.value import Value


class JointType(StrEnum):
    """Types of joints; positions and velocities are in Drake's order."""

    REVOLUTE = "revolute"
    CONTINUOUS = "continuous"
    PRISMATIC = "prismatic"
    PLANAR = "planar"
    FLOATING = "floating"


_POSITIONS = {
    JointType.PLANAR: ("x", "y", "yaw"),
    JointType.FLOATING: ("qw", "qx", "qy", "qz", "x", "y", "z"),
}
_VELOCITIES = {
    JointType.PLANAR: ("x", "y", "yaw"),
    JointType.FLOATING: ("wx", "wy", "wz", "x", "y", "z"),
}
_SCALAR = ("",)
_IN_A_BOX = frozenset({JointType.REVOLUTE, JointType.PRISMATIC})
_WRAPS = {
    JointType.CONTINUOUS: (True,),
    JointType.PLANAR: (False, False, True),
    JointType.FLOATING: (False,) * 6,
}
_NORM_LIMITED = {
    JointType.PLANAR: (("linear", (0, 1)), ("angular", (2,))),
    JointType.FLOATING: (("angular", (0, 1, 2)), ("linear", (3, 4, 5))),
}


@dataclass(frozen=True, eq=False)
class Joint(Value):
    """Joint of a robot.

    Attributes:
        name: Full name, `robot::joint`.
        type: Its type.
    """

    name: str
    type: JointType

    caches_bytes = True

    @property
    def num_positions(self) -> int:
        """Number of position coordinates."""
        return len(_POSITIONS.get(self.type, _SCALAR))

    @property
    def num_velocities(self) -> int:
        """Number of velocity coordinates."""
        return len(_VELOCITIES.get(self.type, _SCALAR))

    @property
    def position_names(self) -> tuple[str, ...]:
        """Name of every position coordinate; a scalar joint's is its own."""
        coordinates = _POSITIONS.get(self.type)
        return tuple(f"{self.name}.{c}" for c in coordinates) if coordinates else (self.name,)

    @property
    def velocity_names(self) -> tuple[str, ...]:
        """Name of every velocity coordinate; a scalar joint's is its own."""
        coordinates = _VELOCITIES.get(self.type)
        return tuple(f"{self.name}.{c}" for c in coordinates) if coordinates else (self.name,)

    @property
    def wraps(self) -> tuple[bool, ...]:
        """Whether each velocity coordinate is an angle on a circle, modulo whole turns."""
        return _WRAPS.get(self.type, (False,))

    @property
    def blocks(self) -> tuple[tuple[str, tuple[int, ...]], ...]:
        """Index sets of velocity coordinates whose Euclidean norm is limited, each with a name.

        Scalar joints have one block of one coordinate; planar and floating joints have one for
        their linear and one for their angular motion.
        """
        pairs = _NORM_LIMITED.get(self.type)
        if pairs is None:
            return ((self.name, (0,)),)
        return tuple((f"{self.name}.{kind}", indices) for kind, indices in pairs)


def offsets_of(
    joints: Iterable[Joint], is_selected: Callable[[Joint], bool]
) -> tuple[tuple[int, int], ...]:
    """Return the first index in q and in v of each joint that a predicate selects."""
    found: list[tuple[int, int]] = []
    iq = iv = 0
    for joint in joints:
        if is_selected(joint):
            found.append((iq, iv))
        iq += joint.num_positions
        iv += joint.num_velocities
    return tuple(found)


@dataclass(frozen=True, eq=False)
class JointGroup(Value):
    """Joint group (planning group): joints that are planned for together.

    Attributes:
        name: `robot` (the robot's default group) or `robot::group`.
        joints: In the group's own order; `q` and `v` stack their coordinates in this order.
        tool_frames: Full names of the frames that the group moves; the first is the default.
        winding: Full names of revolute joints whose whole turns matter, because a follower with a
            fractional multiplier is elsewhere after one.
    """

    name: str
    joints: tuple[Joint, ...]
    tool_frames: tuple[str, ...]
    winding: tuple[str, ...] = ()

    caches_bytes = True

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Full name of every joint."""
        return tuple([joint.name for joint in self.joints])

    @cached_property
    def has_scalar_joints(self) -> bool:
        """Whether every joint has one coordinate with limits: q is a vector in a box."""
        return _IN_A_BOX.issuperset([joint.type for joint in self.joints])

    @cached_property
    def position_names(self) -> tuple[str, ...]:
        """Name of every coordinate of q."""
        return tuple(name for joint in self.joints for name in joint.position_names)

    @cached_property
    def velocity_names(self) -> tuple[str, ...]:
        """Name of every coordinate of v."""
        return tuple(name for joint in self.joints for name in joint.velocity_names)

    @property
    def num_positions(self) -> int:
        """Length of q."""
        return len(self.position_names)

    @property
    def num_velocities(self) -> int:
        """Length of v."""
        return len(self.velocity_names)

    @cached_property
    def additive_indices(self) -> tuple[Indices, Indices]:
        """Indices in q, and in v, of the coordinates that simply add: all but rotations."""
        in_q: list[int] = []
        in_v: list[int] = []
        iq = iv = 0
        for joint in self.joints:
            after_q, after_v = iq + joint.num_positions, iv + joint.num_velocities
            skipped = (4, 3) if joint.type is JointType.FLOATING else (0, 0)
            in_q += range(iq + skipped[0], after_q)
            in_v += range(iv + skipped[1], after_v)
            iq, iv = after_q, after_v
        return np.array(in_q, dtype=np.intp), np.array(in_v, dtype=np.intp)

    @cached_property
    def blocks(self) -> tuple[tuple[str, tuple[int, ...]], ...]:
        """Blocks of all joints, with indices into the group's v."""
        stacked: list[tuple[str, tuple[int, ...]]] = []
        offset = 0
        for joint in self.joints:
            stacked += [(name, tuple(i + offset for i in ix)) for name, ix in joint.blocks]
            offset += joint.num_velocities
        return tuple(stacked)


@dataclass(frozen=True, eq=False)
class JointLimits(Value):
    """Position, velocity, acceleration, jerk and effort limits of a group's joints.

    Positions are limited per position coordinate (infinite where free: quaternions, continuous
    joints, the yaw of a planar joint, unlimited joints of `JointGroup.winding`). Rates are limited
    per block of `JointGroup.blocks`: the Euclidean norm of the block's velocity coordinates stays
    below the number.

    Attributes:
        lower: Smallest position [rad or m], shape (nq,).
        upper: Largest position [rad or m], shape (nq,).
        velocity: [rad/s or m/s], shape (num_blocks,).
        acceleration: [rad/s^2 or m/s^2], shape (num_blocks,).
        jerk: [rad/s^3 or m/s^3], shape (num_blocks,).
        effort: [N m or N], shape (num_blocks,).
        blocks: The group's blocks, as index sets into v.
    """

    lower: Float64[np.ndarray, " nq"]
    upper: Float64[np.ndarray, " nq"]
    velocity: Float64[np.ndarray, " num_blocks"]
    acceleration: Float64[np.ndarray, " num_blocks"]
    jerk: Float64[np.ndarray, " num_blocks"]
    effort: Float64[np.ndarray, " num_blocks"]
    blocks: tuple[tuple[int, ...], ...]

    def scaled(self, velocity: float, acceleration: float) -> "JointLimits":
        """Return limits with velocity, and acceleration with jerk, scaled (factors in (0, 1])."""
        if velocity == acceleration == 1:
            return self
        return JointLimits(
            self.lower,
            self.upper,
            self.velocity * velocity,
            self.acceleration * acceleration,
            self.jerk * acceleration,
            self.effort,
            self.blocks,
        )

    def per_coordinate(
        self, rates: Float64[np.ndarray, " num_blocks"]
    ) -> Float64[np.ndarray, " nv"]:
        """Return bounds per velocity coordinate that imply the blocks' bounds.

        A block of k coordinates gets the cube inscribed in its ball: rate / sqrt(k).
        """
        bounds = np.zeros(sum(len(block) for block in self.blocks))
        for rate, block in zip(rates, self.blocks, strict=True):
            bounds[list(block)] = rate / np.sqrt(len(block))
        return bounds
