"""A motion against its limits over time: the numbers of its plots."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.curve import TimedTrajectory
from planning.domain.joints import JointGroup, JointLimits
from planning.domain.options import RetimeOptions
from planning.domain.value import Value
from planning.retime.path_limits import path_limits
from planning.timing import admit_timing
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
        shares: How much is used of each limit that was asked for besides those of joints [1], by
            its check in the certificate: `acceleration`, `tool_speed <frame>`,
            `tool_acceleration <frame>`, `speed_zone <name>`, which is zero outside of the zone.
    """

    group: JointGroup
    limits: JointLimits
    times: Float64[np.ndarray, " m"]
    positions: Float64[np.ndarray, "m nq"]
    rates: Float64[np.ndarray, "3 m nv"]
    efforts: Float64[np.ndarray, "m nv"]
    clearance: Float64[np.ndarray, " m"]
    pairs: tuple[tuple[str, str], ...]
    shares: Mapping[str, Float64[np.ndarray, "m limits"]]

    @property
    def utilisation(self) -> dict[str, Array]:
        """Rate or effort over its limit, by the name of its check, each of shape (m, limits).

        Of joints there is a column for each block, and for `acceleration` one more for each that
        has bounds by sign.
        """
        limits = self.limits
        amounts = {
            "velocity": (self.rates[0], limits.velocity),
            "acceleration": (self.rates[1], limits.acceleration),
            "jerk": (self.rates[2], limits.jerk),
            "torque": (self.efforts, limits.effort),
        }
        used = {
            name: np.stack(
                [np.linalg.norm(values[:, list(block)], axis=1) for block in limits.blocks], axis=1
            )
            / bound
            for name, (values, bound) in amounts.items()
        }
        for name, more in self.shares.items():
            used[name] = np.concatenate([used[name], more], axis=1) if name in used else more
        return used


def motion_series(
    world: World,
    group: str,
    trajectory: TimedTrajectory,
    count: int = 201,
    options: RetimeOptions | None = None,
) -> MotionSeries:
    """Return a motion's numbers at evenly spread instants.

    Distances are Drake's, which overstates those of separate boxes (docs/decisions/0006): the
    certificate has what is proven.

    Args:
        world: The scene, loaded.
        group: What moves.
        trajectory: The motion, one of the group's joints.
        count: Of instants, at least 2.
        options: The limits besides those of joints, and what the group carries that the scene does
            not show.

    Raises:
        UnknownName: There is no such group, frame or joint.
        ProblemInvalid: A limit makes no sense, or the group does not move the payload.
    """
    joints = world.group(group)
    asked = admit_timing(world, joints, options or RetimeOptions(), trajectory.start)
    dynamics = GroupDynamics(world, joints, asked.payload)
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
        shares=_shares(world, joints, asked, trajectory, times),
    )


def _shares(
    world: World,
    group: JointGroup,
    options: RetimeOptions,
    trajectory: TimedTrajectory,
    times: Array,
) -> dict[str, Array]:
    """Return how much of the limits besides those of joints is used, by the names of checks."""
    shares: dict[str, list[Array]] = {}
    # Torques have a series of their own, limited or not.
    for limit in path_limits(world, group, replace(options, effort=False)):
        for where, share in limit.shares(trajectory, times).items():
            is_of_joint = limit.name == "acceleration_bounds"
            name = "acceleration" if is_of_joint else f"{limit.name} {where}"
            shares.setdefault(name, []).append(share)
    return {name: np.stack(columns, axis=1) for name, columns in shares.items()}
