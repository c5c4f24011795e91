"""Followers: mimic joints of a group's joints, and the limits that they impose on the group.

A follower is at q_f = multiplier q + offset of the joint that it follows, through any chain of
followers. So its limits are limits of that joint: positions between those where q_f is at its
bounds, and rates divided by |multiplier|.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.robot.joints import JointLimits
from planning.domain.value import Value
from planning.errors import ModelInvalid


@dataclass(frozen=True, eq=False)
class Follower(Value):
    """Mimic joint of a group's joint, with its own limits.

    Attributes:
        name: Full name, `robot::joint`.
        leader: Full name of the group's joint that moves it.
        position_index: Index of that joint's coordinate in the group's q.
        velocity_index: Index of the same in the group's v.
        block_index: Index of the joint's block.
        multiplier: Its displacement over that of the leader, of either sign.
        offset: Its position with the leader at 0 [rad or m].
        lower: Smallest position [rad or m].
        upper: Largest position [rad or m].
        velocity: [rad/s or m/s], infinite where no limit is stated.
        acceleration: [rad/s^2 or m/s^2], infinite where no limit is stated.
        jerk: [rad/s^3 or m/s^3], infinite where no limit is stated.
    """

    name: str
    leader: str
    position_index: int
    velocity_index: int
    block_index: int
    multiplier: float
    offset: float
    lower: float = -np.inf
    upper: float = np.inf
    velocity: float = np.inf
    acceleration: float = np.inf
    jerk: float = np.inf

    def scaled(self, velocity: float, acceleration: float) -> "Follower":
        """Return it with velocity, and acceleration with jerk, scaled (factors in (0, 1])."""
        return replace(
            self,
            velocity=self.velocity * velocity,
            acceleration=self.acceleration * acceleration,
            jerk=self.jerk * acceleration,
        )

    @property
    def leader_range(self) -> tuple[float, float]:
        """Range of the leader's positions in which the follower keeps its own limits [rad or m]."""
        if self.multiplier == 0:
            return (-np.inf, np.inf)
        ends = [(bound - self.offset) / self.multiplier for bound in (self.lower, self.upper)]
        return min(ends), max(ends)


def combine_limits(limits: JointLimits, followers: Sequence[Follower]) -> JointLimits:
    """Return the limits of a group that imply the limits of its followers as well.

    Raises:
        ModelInvalid: No position of a leader keeps both its own limits and its follower's.
    """
    if not followers:
        return limits
    lower, upper = np.array(limits.lower), np.array(limits.upper)
    rates = {name: np.array(getattr(limits, name)) for name in ("velocity", "acceleration", "jerk")}
    for follower in followers:
        index = follower.position_index
        low, high = follower.leader_range
        lower[index], upper[index] = max(lower[index], low), min(upper[index], high)
        is_fixed = follower.multiplier == 0
        if lower[index] > upper[index] or (
            is_fixed and not follower.lower <= follower.offset <= follower.upper
        ):
            raise _no_position_error(follower)
        for name, bounds in rates.items():
            if not is_fixed:
                allowed = getattr(follower, name) / abs(follower.multiplier)
                bounds[follower.block_index] = min(bounds[follower.block_index], allowed)
    return replace(limits, lower=lower, upper=upper, **rates)


def _no_position_error(follower: Follower) -> ModelInvalid:
    message = (
        f"mimic joint {follower.name!r} (q = {follower.multiplier:g} * {follower.leader!r} + "
        f"{follower.offset:g}) is outside its limits [{follower.lower:g}, {follower.upper:g}] at "
        "every position that the limits of its leader and of its leader's other followers permit"
    )
    return ModelInvalid(message, {"joint": follower.name, "reason": message})
