"""Whole turns of joints: whether a joint's followers are unchanged by them.

Drake counts positions of joints on the real line. In `planning` an unlimited revolute joint is on a
circle, modulo whole turns. That is valid only if a whole turn brings all its followers back to
where they were, and their limits permit it: a follower with multiplier 1/2 is half a turn off.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.multibody.tree import RevoluteJoint

from planning.world.drake_model import DrakeModel

# Tolerance for whole-number multipliers, such as 0.1 times 10.
_MULTIPLIER_TOLERANCE = 1e-12


@dataclass(frozen=True)
class JointFollower:
    """Follower of a joint, directly or through others.

    Attributes:
        joint: Drake's.
        multiplier: Its displacement over that of the first leader.
        offset: Its position with the first leader at 0 [rad or m].
    """

    joint: Any
    multiplier: float
    offset: float

    @property
    def is_moved_by_whole_turns(self) -> bool:
        """Whether its child body is elsewhere after a whole turn of the leader."""
        is_whole = abs(self.multiplier - round(self.multiplier)) <= _MULTIPLIER_TOLERANCE
        return self.multiplier != 0 and not (is_whole and isinstance(self.joint, RevoluteJoint))


def joint_followers(model: DrakeModel, name: str) -> tuple[JointFollower, ...]:
    """Return all followers of a joint of one coordinate, by full name; leaders first."""
    plant = model.plant
    index = model.joint_indices[name]
    joints = {int(plant.get_joint(i).velocity_start()): i for i in model.joint_indices.values()}
    found = {
        int(plant.get_joint(index).velocity_start()): JointFollower(
            plant.get_joint(index), 1.0, 0.0
        )
    }
    for c in model.couplings:
        leader = found.get(c.leader_velocity)
        if leader is not None:
            found[c.follower_velocity] = JointFollower(
                plant.get_joint(joints[c.follower_velocity]),
                c.multiplier * leader.multiplier,
                c.multiplier * leader.offset + c.offset,
            )
    return tuple(found.values())[1:]


def is_continuous(model: DrakeModel, name: str) -> bool:
    """Return whether a revolute joint is unlimited and on a circle, modulo whole turns."""
    joint = model.plant.get_joint(model.joint_indices[name])
    followers = [follower for follower in joint_followers(model, name) if follower.multiplier != 0]
    joints = [joint, *(follower.joint for follower in followers)]
    bounds = [(*j.position_lower_limits(), *j.position_upper_limits()) for j in joints]
    is_limited = bool(np.isfinite(bounds).any())
    return not is_limited and not any(f.is_moved_by_whole_turns for f in followers)
