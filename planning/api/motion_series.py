"""motion_series(): samples of a motion with its rates, efforts, distances and limits, for plots."""

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
from planning.pipeline.timing.timing_options import resolve_retiming
from planning.retime.limits.request_limits import path_limits
from planning.world.collision.margins import PairMargins
from planning.world.mechanics.dynamics import GroupDynamics
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Search radii beyond the largest margin, tried in turn: a small one is faster, mostly enough [m].
_DISTANCE_RANGES = (0.1, 0.5)
_MAX_DISTANCE = _DISTANCE_RANGES[-1]
# Bound on the difference between two measurements of the same distance [m].
_DISTANCE_TOLERANCE = 1e-9
# Smallest jump of acceleration at a break, as a share of the limit, and the distance from the break
# of the samples before and after it, as a share of the duration.
_MIN_JUMP, _JUMP_OFFSET = 1e-3, 1e-9


@dataclass(frozen=True, eq=False)
class MotionSeries(Value):
    """Samples of a motion at equal time steps.

    Attributes:
        group: Joint group that moves.
        limits: Limits of the group, scaled by the options.
        options: Options with the other limits, zones in world; jerk is limited if `method` is
            "ruckig".
        times: Instants of the samples [s].
        positions: Configurations [rad or m].
        derivatives: Derivatives of order k = 1, 2 and 3 in velocity coordinates: velocity,
            acceleration and jerk [rad/s^k or m/s^k].
        acceleration_jumps: Instants within the motion at which acceleration jumps, so that jerk is
            infinite [s].
        efforts: Joint torques and forces of the motion [N m or N].
        clearance: Smallest signed distance of any two bodies that may collide [m]; half a metre
            more than the largest margin where all are farther apart. NaN without distances.
        closest_pairs: Body pair of each clearance, or two empty names.
        margin: Required distance of bodies of different robots and objects [m].
        signed_margin: Smallest difference of distance and required margin over all body pairs [m],
            at most half a metre; the margin of two bodies of one robot is 0. NaN without distances.
        tool_speeds: Speeds of the origins of the group's tool frame and of all limited frames, by
            frame [m/s].
        path_limit_utilisation: Utilization of each limit besides those of joints [1], by its check
            in the certificate: `acceleration`, `tool_speed <frame>`, `tool_acceleration <frame>`,
            `speed_zone <name>`, which is zero outside of the zone.
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
        """Whether jerk was limited; else acceleration may jump, and jerk is not meaningful."""
        return self.options.limits_jerk

    @property
    def acceleration_range(self) -> tuple[Float64[np.ndarray, " nv"], Float64[np.ndarray, " nv"]]:
        """Lowest and highest acceleration of every velocity coordinate.

        A block of several coordinates is limited by its norm; each of its coordinates gets the
        whole bound.
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
        """Ratio of rate or effort to its limit, by the name of its check, each shape (m, limits).

        Joint limits have one column per block, and `acceleration` one more for each coordinate with
        bounds by sign. `jerk` is present only if it is limited; `torque` always, limited or not.
        """
        limits = self.limits
        values_and_limits = {
            "velocity": (self.derivatives[0], limits.velocity),
            "acceleration": (self.derivatives[1], limits.acceleration),
            "torque": (self.efforts, limits.effort),
        }
        if self.is_jerk_limited:
            values_and_limits["jerk"] = self.derivatives[2], limits.jerk
        utilisation = {
            name: _block_norms(values, limits) / bound
            for name, (values, bound) in values_and_limits.items()
        }
        for name, columns in self.path_limit_utilisation.items():
            utilisation[name] = (
                np.concatenate([utilisation[name], columns], axis=1)
                if name in utilisation
                else columns
            )
        return utilisation


def motion_series(  # noqa: PLR0913  (all inputs of a request)
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
    """Return samples of a motion, its rates, efforts and distances at equal time steps.

    Distances are Drake's, which overstates those of separate boxes (docs/decisions/0006); proven
    bounds are in the certificate.

    Args:
        world: Loaded scene.
        group: Joint group that moves, `robot` or `robot::group`.
        trajectory: Motion of the group's joints.
        num_samples: Number of instants, at least 2.
        options: Scales of the limits, whether jerk is limited (`method`), the limits besides those
            of joints, and the payload; None for the defaults.
        margin: Required distance of bodies [m]; None for the scene's.
        distances: Whether to measure distances of bodies, which takes most of the time.
        deadline: Time limit.

    Raises:
        UnknownName: There is no such group, frame or joint.
        ProblemInvalid: A limit is invalid, or the group does not move the payload.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
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
    """Return clearances, closest pairs and signed margins at rows of full configurations."""
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
            # Exact distances of all pairs up to the one with the smallest margin.
            exact_pairs = (
                ()
                if tightest is None
                else probe.pairs_within(full, tightest.distance + _DISTANCE_TOLERANCE, exactly=True)
            )
            min_margin = min(
                (p.distance - margins.of(*p.bodies) for p in exact_pairs), default=np.inf
            )
            # Pairs beyond the search radius have a larger margin than that.
            if min_margin <= max_distance:
                signed_margin[i] = min_margin
                break
        closest_pairs.append(exact_pairs[0].bodies if exact_pairs else ("", ""))
        if exact_pairs:
            clearance[i] = exact_pairs[0].distance
    return clearance, tuple(closest_pairs), signed_margin


def _acceleration_jumps(trajectory: TimedTrajectory, limits: JointLimits) -> Array:
    """Return the instants at which the acceleration of a block jumps [s]."""
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
    """Return the utilization of the limits besides those of joints, by the names of checks."""
    utilisation: dict[str, list[Array]] = {}
    # Torques are in `efforts`, limited or not.
    for limit in path_limits(world, group, replace(options, effort=False)):
        for where, values in limit.sampled_utilization(trajectory, times).items():
            is_of_joint = limit.name == "acceleration_bounds"
            name = "acceleration" if is_of_joint else f"{limit.name} {where}"
            utilisation.setdefault(name, []).append(values)
    return {name: np.stack(columns, axis=1) for name, columns in utilisation.items()}
