"""A motion against its limits over time: the numbers of its plots."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.curve import TimedTrajectory
from planning.domain.joints import JointGroup, JointLimits
from planning.domain.payload import Payload
from planning.domain.value import Value
from planning.world.dynamics import GroupDynamics
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Bodies farther apart than this are not of interest, and cost time [m].
_FARTHEST = 0.5


@dataclass(frozen=True, eq=False)
class MotionSeries(Value):
    """Samples, evenly spread over the motion.

    Attributes:
        group: What moves.
        limits: What it may do, unscaled.
        times: [s].
        positions: [rad or m].
        rates: The tangent's derivatives of order 1, 2 and 3: velocity, acceleration and jerk
            [rad/s^k or m/s^k].
        efforts: What the motion takes of each joint [N m or N].
        clearance: Smallest signed distance of any two bodies that may collide [m], half a metre
            where all are farther apart.
        pairs: Whose it is, or two empty names.
    """

    group: JointGroup
    limits: JointLimits
    times: Float64[np.ndarray, " m"]
    positions: Float64[np.ndarray, "m nq"]
    rates: Float64[np.ndarray, "3 m nv"]
    efforts: Float64[np.ndarray, "m nv"]
    clearance: Float64[np.ndarray, " m"]
    pairs: tuple[tuple[str, str], ...]

    @property
    def utilisation(self) -> dict[str, Array]:
        """Rate or effort over its limit, by name, each of shape (m, num_blocks)."""
        limits = self.limits
        amounts = {
            "velocity": (self.rates[0], limits.velocity),
            "acceleration": (self.rates[1], limits.acceleration),
            "jerk": (self.rates[2], limits.jerk),
            "torque": (self.efforts, limits.effort),
        }
        return {
            name: np.stack(
                [np.linalg.norm(values[:, list(block)], axis=1) for block in limits.blocks], axis=1
            )
            / bound
            for name, (values, bound) in amounts.items()
        }


def motion_series(
    world: World,
    group: str,
    trajectory: TimedTrajectory,
    count: int = 201,
    payload: Payload | None = None,
) -> MotionSeries:
    """Return a motion's numbers at evenly spread instants.

    Distances are Drake's, which overstates those of separate boxes (docs/decisions/0006): the
    certificate has what is proven.

    Args:
        world: The scene, loaded.
        group: What moves.
        trajectory: The motion, one of the group's joints.
        count: Of instants, at least 2.
        payload: What the group carries that the scene does not show.

    Raises:
        UnknownName: There is no such group, or no such frame as the payload's.
        ProblemInvalid: The group does not move the payload.
    """
    joints = world.group(group)
    dynamics = GroupDynamics(world, joints, payload)
    times = np.linspace(0.0, trajectory.duration, count)
    q = trajectory.positions(times)
    probe = world.distance_probe(world.margins())
    nearest = [probe.pairs_within(full, _FARTHEST)[:1] for full in world.embed(joints, q)]
    return MotionSeries(
        group=joints,
        limits=world.limits(joints),
        times=times,
        positions=q,
        rates=np.stack([trajectory.tangents(times, order) for order in (1, 2, 3)]),
        efforts=dynamics.efforts(q, trajectory.velocities(times), trajectory.accelerations(times)),
        clearance=np.array([pairs[0].distance if pairs else _FARTHEST for pairs in nearest]),
        pairs=tuple(pairs[0].bodies if pairs else ("", "") for pairs in nearest),
    )
