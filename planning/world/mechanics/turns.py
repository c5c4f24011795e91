"""What a joint leads, and whether whole turns of it leave that as it was.

Drake counts positions of joints on the real line. For us a joint that turns without end is on a
circle, where whole turns are nothing. That is true only if all that follows it is where it was
after a whole turn, and may go there: a follower by half is half a turn off.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.multibody.tree import RevoluteJoint

from planning.world.drake_model import DrakeModel

# Multipliers this near to a whole number are one, such as 0.1 times 10.
_DUST = 1e-12


@dataclass(frozen=True)
class Led:
    """A joint that follows another one, directly or through others.

    Attributes:
        joint: Drake's.
        multiplier: Its displacement over that of the joint that leads all of them.
        offset: Where it is if that is at 0 [rad or m].
    """

    joint: Any
    multiplier: float
    offset: float

    @property
    def minds_turns(self) -> bool:
        """Whether its child is elsewhere after a whole turn of what leads."""
        is_whole = abs(self.multiplier - round(self.multiplier)) <= _DUST
        return self.multiplier != 0 and not (is_whole and isinstance(self.joint, RevoluteJoint))


def led_by(model: DrakeModel, name: str) -> tuple[Led, ...]:
    """Return all that follows a joint of one coordinate, by full name; leaders first."""
    plant = model.plant
    index = model.joint_indices[name]
    joints = {int(plant.get_joint(i).velocity_start()): i for i in model.joint_indices.values()}
    found = {int(plant.get_joint(index).velocity_start()): Led(plant.get_joint(index), 1.0, 0.0)}
    for c in model.couplings:
        leader = found.get(c.leader_velocity)
        if leader is not None:
            found[c.follower_velocity] = Led(
                plant.get_joint(joints[c.follower_velocity]),
                c.multiplier * leader.multiplier,
                c.multiplier * leader.offset + c.offset,
            )
    return tuple(found.values())[1:]


def is_endless(model: DrakeModel, name: str) -> bool:
    """Return whether a joint that turns may do so without end, and whole turns are nothing."""
    joint = model.plant.get_joint(model.joint_indices[name])
    led = [each for each in led_by(model, name) if each.multiplier != 0]
    bounds = [
        bound
        for each in (joint, *(other.joint for other in led))
        for bound in (*each.position_lower_limits(), *each.position_upper_limits())
    ]
    return not np.isfinite(bounds).any() and not any(each.minds_turns for each in led)
