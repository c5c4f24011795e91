"""Limits of mimic joints that follow those of a group."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from planning.domain.robot.followers import Follower, combine_limits
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.world.drake_model import DrakeModel
from planning.world.loading.scene_build import LoadedRobot
from planning.world.mechanics.joint_followers import joint_followers
from planning.world.models.groups import (
    ACCELERATION_PER_VELOCITY,
    JERK_PER_ACCELERATION,
    group_limits,
)
from planning.world.models.robot_card import LimitsCard

_NO_LIMITS = LimitsCard()


def combined_limits(
    model: DrakeModel, group: JointGroup, robots: Sequence[LoadedRobot]
) -> JointLimits:
    """Return the limits under which a group and all its followers keep their own.

    Raises:
        ModelInvalid: No position of a leader keeps both its own limits and its follower's.
    """
    own = group_limits(model, group, list(robots))
    return combine_limits(own, followers_of(model, group, robots))


def followers_of(
    model: DrakeModel, group: JointGroup, robots: Sequence[LoadedRobot]
) -> tuple[Follower, ...]:
    """Return the joints that follow those of a group, directly or through others.

    Positions and velocities are limited by the card, or else the description. Accelerations and
    jerks are limited by the card; if it states none for the follower and none for the leader, they
    are assumed from the follower's velocity as those of any joint are.
    """
    cards = {r.scene_robot.name: r.source.card.limits for r in robots if r.source.card}
    found: list[Follower] = []
    iq = iv = block = 0
    for joint in group.joints:
        robot, _, leader = joint.name.partition("::")
        card = cards.get(robot, {})
        for follower in joint_followers(model, joint.name):
            name = follower.joint.name()
            stated = card.get(name, _NO_LIMITS)
            low, high = _position_range(follower.joint, stated)
            rates = _rates(follower.joint, stated, card.get(leader, _NO_LIMITS))
            found.append(
                Follower(
                    name=f"{robot}::{name}",
                    leader=joint.name,
                    position_index=iq,
                    velocity_index=iv,
                    block_index=block,
                    multiplier=follower.multiplier,
                    offset=follower.offset,
                    lower=low,
                    upper=high,
                    velocity=rates[0],
                    acceleration=rates[1],
                    jerk=rates[2],
                )
            )
        iq, iv = iq + joint.num_positions, iv + joint.num_velocities
        block += len(joint.blocks)
    return tuple(found)


def _position_range(joint: Any, stated: LimitsCard) -> tuple[float, float]:
    from_file = joint.position_lower_limits()[0], joint.position_upper_limits()[0]
    low, high = stated.position.get(joint.name(), from_file)
    return float(low), float(high)


def _rates(joint: Any, stated: LimitsCard, of_leader: LimitsCard) -> tuple[float, float, float]:
    from_file = float(joint.velocity_upper_limits()[0])
    velocity = stated.velocity or (from_file if from_file > 0 else np.inf)
    assumed = np.inf if of_leader.acceleration else velocity * ACCELERATION_PER_VELOCITY
    acceleration = stated.acceleration or assumed
    assumed = np.inf if of_leader.jerk else acceleration * JERK_PER_ACCELERATION
    return velocity, acceleration, stated.jerk or assumed
