"""A motion against its limits over time: the numbers of its plots."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.request.deadline import NO_DEADLINE, Deadline
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.value import Value
from planning.pipeline.timing_options import resolve_retiming
from planning.retime.limits.request_limits import path_limits
from planning.world.collision.margins import PairMargins
from planning.world.mechanics.dynamics import GroupDynamics
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Bodies that have more than the last to spare are not of interest; few are looked at first [m].
_DISTANCE_RANGES = (0.1, 0.5)
_MAX_DISTANCE = _DISTANCE_RANGES[-1]
# A distance that is measured again differs by less [m].
_DISTANCE_TOLERANCE = 1e-9
# Accelerations just before and after a break that differ by this share of the limit have jumped;
# how near to the break they are looked at, as a share of the duration.
_MIN_JUMP, _JUMP_OFFSET = 1e-3, 1e-9


@dataclass(frozen=True, eq=False)
class MotionSeries(Value):
    """Samples, evenly spread over the motion.

    Attributes:
        group: What moves.
        limits: What it may do: the group's limits, scaled as the options say.
        options: The limits besides, with zones in world; jerk is limited if `method` is "ruckig".
        times: [s].
        positions: [rad or m].
        derivatives: The tangent's derivatives of order 1, 2 and 3: velocity, acceleration and jerk
            [rad/s^k or m/s^k].
        acceleration_jumps: When acceleration jumps within the motion, which no finite jerk does
            [s].
        efforts: What the motion takes of each joint [N m or N].
        clearance: Smallest signed distance of any two bodies that may collide [m]; where all are
            farther apart, half a metre more than the largest margin. Like `signed_margin`, not a
            number if distances were left out.
        closest_pairs: Whose it is, or two empty names.
        margin: What is demanded of bodies of different robots and objects [m].
        signed_margin: The least that any two bodies have to spare over the margin demanded of them
            [m], at most half a metre. Bodies of one robot owe each other none.
        tool_speeds: Of the origins of the group's tool frame and of all frames that are limited, by
            their names [m/s].
        path_limit_utilisation: How much is used of each limit that was asked for besides those of
            joints [1], by its check in the certificate: `acceleration`, `tool_speed <frame>`,
            `tool_acceleration <frame>`, `speed_zone <name>`, which is zero outside of the zone.
    """

    group: JointGroup
    limits: JointLimits
    options: RetimeOptions
    times: Float64[np.ndarray, " m"]
    positions: Float64[np.ndarray, "m nq"]
    derivatives: Float64[np.ndarray, "3 m nv"]
    acceleration_jumps: Float64[np.ndarray, " k"]
    efforts: Float64[np.ndarray, "m nv"]
    clearance: Float64[np.ndarray, " m"]
    closest_pairs: tuple[tuple[str, str], ...]
    margin: float
    signed_margin: Float64[np.ndarray, " m"]
    tool_speeds: Mapping[str, Float64[np.ndarray, " m"]]
    path_limit_utilisation: Mapping[str, Float64[np.ndarray, "m limits"]]

    @property
    def is_jerk_limited(self) -> bool:
        """Whether jerk was limited; else acceleration may jump, and jerk says nothing."""
        return self.options.method == "ruckig"

    @property
    def acceleration_range(self) -> tuple[Float64[np.ndarray, " nv"], Float64[np.ndarray, " nv"]]:
        """Lowest and highest acceleration of every coordinate, with bounds by sign.

        A block of several coordinates is limited by its norm: each alone may use all of it.
        """
        highest = np.zeros(self.derivatives.shape[2])
        for block, bound in zip(self.limits.blocks, self.limits.acceleration, strict=True):
            highest[list(block)] = bound
        lowest = -highest
        columns = dict(self.group.blocks)
        for name, (low, high) in self.options.acceleration_bounds.items():
            i = columns[name][0]
            lowest[i], highest[i] = max(low, lowest[i]), min(high, highest[i])
        return lowest, highest

    @property
    def utilisation(self) -> dict[str, Array]:
        """Rate or effort over its limit, by the name of its check, each of shape (m, limits).

        Of joints there is a column for each block, and for `acceleration` one more for each that
        has bounds by sign. `jerk` is there only if it is limited; `torque` always, limited or not.
        """
        limits = self.limits
        amounts = {
            "velocity": (self.derivatives[0], limits.velocity),
            "acceleration": (self.derivatives[1], limits.acceleration),
            "torque": (self.efforts, limits.effort),
        }
        if self.is_jerk_limited:
            amounts["jerk"] = self.derivatives[2], limits.jerk
        utilisation = {
            name: _block_norms(values, limits) / bound for name, (values, bound) in amounts.items()
        }
        for name, columns in self.path_limit_utilisation.items():
            utilisation[name] = (
                np.concatenate([utilisation[name], columns], axis=1)
                if name in utilisation
                else columns
            )
        return utilisation


def motion_series(  # noqa: PLR0913  (a question in full)
    world: World,
    group: str,
    trajectory: TimedTrajectory,
    num_samples: int = 201,
    options: RetimeOptions | None = None,
    margin: float | None = None,
    *,
    distances: bool = True,
    deadline: Deadline = NO_DEADLINE,
) -> MotionSeries:
    """Return a motion's numbers at evenly spread instants.

    Distances are Drake's, which overstates those of separate boxes (docs/decisions/0006): the
    certificate has what is proven.

    Args:
        world: The scene, loaded.
        group: What moves.
        trajectory: The motion, one of the group's joints.
        num_samples: Of instants, at least 2.
        options: The scales of the limits, whether jerk is limited (`method`), the limits besides
            those of joints, and what the group carries that the scene does not show.
        margin: The distance that was to be kept [m]; None for the scene's.
        distances: Whether to measure those of bodies, which takes most of the time.
        deadline: When to give up.

    Raises:
        UnknownName: There is no such group, frame or joint.
        ProblemInvalid: A limit makes no sense, or the group does not move the payload.
        DeadlineExceeded: Time ran out.
        Canceled: The end was asked for.
    """
    joints = world.group(group)
    retiming = resolve_retiming(world, joints, options or RetimeOptions(), trajectory.start)
    dynamics = GroupDynamics(world, joints, retiming.payload)
    limits = world.limits(joints).scaled(retiming.velocity_scale, retiming.acceleration_scale)
    times = np.linspace(0.0, trajectory.duration, num_samples)
    q, v = trajectory.positions(times), trajectory.velocities(times)
    margins = world.margins(margin)
    clearance, closest_pairs, signed_margin = (
        _distances(world, margins, world.embed(joints, q), deadline)
        if distances
        else (np.full(num_samples, np.nan), (("", ""),) * num_samples, np.full(num_samples, np.nan))
    )
    return MotionSeries(
        group=joints,
        limits=limits,
        options=retiming,
        times=times,
        positions=q,
        derivatives=np.stack([trajectory.tangents(times, order) for order in (1, 2, 3)]),
        acceleration_jumps=_acceleration_jumps(trajectory, limits),
        efforts=dynamics.efforts(q, v, trajectory.accelerations(times)),
        clearance=clearance,
        closest_pairs=closest_pairs,
        margin=margins.default,
        signed_margin=signed_margin,
        tool_speeds=_tool_speeds(world, joints, retiming, (q, v)),
        path_limit_utilisation=_path_limit_utilisation(world, joints, retiming, trajectory, times),
    )


def _distances(
    world: World, margins: PairMargins, states: Array, deadline: Deadline
) -> tuple[Array, tuple[tuple[str, str], ...], Array]:
    """Return the least distance, whose it is, and the least to spare, at full positions by rows."""
    probe = world.distance_probe(margins)
    largest = max(margins.largest, 0.0)
    clearance = np.full(len(states), _MAX_DISTANCE + largest)
    signed_margin = np.full(len(states), _MAX_DISTANCE)
    closest_pairs: list[tuple[str, str]] = []
    for i, full in enumerate(states):
        deadline.check("series")
        exact_pairs = ()
        for max_distance in _DISTANCE_RANGES:
            nearby_pairs = probe.pairs_within(full, max_distance + largest)
            tightest = min(
                nearby_pairs, key=lambda p: p.distance - margins.of(*p.bodies), default=None
            )
            # Of what is nearer than the pair that counts, and of it, the true distances.
            exact_pairs = (
                ()
                if tightest is None
                else probe.pairs_within(full, tightest.distance + _DISTANCE_TOLERANCE, exactly=True)
            )
            min_margin = min(
                (p.distance - margins.of(*p.bodies) for p in exact_pairs), default=np.inf
            )
            # What is beyond the horizon has more than that to spare.
            if min_margin <= max_distance:
                signed_margin[i] = min_margin
                break
        closest_pairs.append(exact_pairs[0].bodies if exact_pairs else ("", ""))
        if exact_pairs:
            clearance[i] = exact_pairs[0].distance
    return clearance, tuple(closest_pairs), signed_margin


def _acceleration_jumps(trajectory: TimedTrajectory, limits: JointLimits) -> Array:
    """Return the instants at which acceleration jumps, by the norms of blocks."""
    breaks, offset = trajectory.breaks[1:-1], _JUMP_OFFSET * trajectory.duration
    steps = trajectory.accelerations(breaks + offset) - trajectory.accelerations(breaks - offset)
    sizes = _block_norms(steps, limits) / limits.acceleration
    return breaks[(sizes > _MIN_JUMP).any(axis=1)]


def _block_norms(values: Array, limits: JointLimits) -> Array:
    """Return the norm of every block, shape (m, num_blocks)."""
    return np.stack(
        [np.linalg.norm(values[:, list(block)], axis=1) for block in limits.blocks], axis=1
    )


def _tool_speeds(
    world: World, group: JointGroup, options: RetimeOptions, states: tuple[Array, Array]
) -> dict[str, Array]:
    """Return the speeds of frames at rows of q and v [m/s]."""
    limited = [entry.frame for entry in (*options.tool_limits, *options.speed_zones)]
    return {
        frame: np.linalg.norm(ToolKinematics(world, group, frame).velocities(*states), axis=1)
        for frame in dict.fromkeys([*group.tool_frames[:1], *limited])
    }


def _path_limit_utilisation(
    world: World,
    group: JointGroup,
    options: RetimeOptions,
    trajectory: TimedTrajectory,
    times: Array,
) -> dict[str, Array]:
    """Return how much of the limits besides those of joints is used, by the names of checks."""
    utilisation: dict[str, list[Array]] = {}
    # Torques have a series of their own, limited or not.
    for limit in path_limits(world, group, replace(options, effort=False)):
        for where, values in limit.sampled_utilization(trajectory, times).items():
            is_of_joint = limit.name == "acceleration_bounds"
            name = "acceleration" if is_of_joint else f"{limit.name} {where}"
            utilisation.setdefault(name, []).append(values)
    return {name: np.stack(columns, axis=1) for name, columns in utilisation.items()}
