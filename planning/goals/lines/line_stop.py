"""LineStop of a traced line: joint limit, collision, singularity or reach, with its evidence."""

from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.geometry.body_pair import BodyPair
from planning.domain.goals.line_trace import LineStop, LineTrace
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.goals.lines.trace_state import TraceState, TraceStop
from planning.goals.start_validation import pair_evidence
from planning.world.collision.margins import PairMargins
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Singular values below this count as zero: the group cannot move the tool in that direction.
_ZERO_SINGULAR_VALUE = 1e-6
# Singular values below this are a singularity [1 or m per rad].
_SINGULARITY_THRESHOLD = 0.02
_RIGID_BODY_DOFS = 6
# A redundant joint this near to its limit is stopped there [rad or m].
_AT_LIMIT = 1e-3
# Distance beyond their margin up to which pairs are considered [m].
_INFLUENCE_DISTANCE = 1e-3


def make_line_trace(
    world: World,
    group: JointGroup,
    margins: PairMargins,
    kinematics: ToolKinematics,
    trace_state: TraceState,
) -> LineTrace:
    """Return the line trace of a trace state, with its stop; the stop is None at the line's end."""
    stop = None if not trace_state.stop else _stop(world, group, margins, kinematics, trace_state)
    return LineTrace(
        line=trace_state.line,
        fractions=np.array(trace_state.fractions),
        positions=np.stack(trace_state.waypoints),
        max_position_deviation=trace_state.max_shift,
        max_rotation_deviation=trace_state.max_turn,
        stop=stop,
    )


def _stop(
    world: World,
    group: JointGroup,
    margins: PairMargins,
    kinematics: ToolKinematics,
    trace_state: TraceState,
) -> LineStop:
    q = trace_state.waypoints[-1]
    value, rank = _singular_value(kinematics, Manifold(group.joints), q)
    joint, pair = "", None
    match trace_state.stop:
        case TraceStop.LIMIT:
            reason, joint = "limit", _joint_outside(world, group, trace_state.infeasible_q)
        case TraceStop.COLLISION:
            reason, pair = "collision", _worst_pair(world, group, trace_state.infeasible_q, margins)
        case _:
            is_singularity = rank == _RIGID_BODY_DOFS or 0 < value <= _SINGULARITY_THRESHOLD
            reason = "singularity" if is_singularity else "unreachable"
            if (
                is_singularity
                and value > _SINGULARITY_THRESHOLD
                and _limit_margin(world, group, q) < _AT_LIMIT
            ):
                reason, joint = "limit", _joint_outside(world, group, q)
    return LineStop(
        reason,
        trace_state.fraction,
        trace_state.line.pose(trace_state.fraction),
        q,
        joint,
        pair,
        value,
    )


def _singular_value(kinematics: ToolKinematics, manifold: Manifold, q: Array) -> tuple[float, int]:
    """Return the smallest generically nonzero singular value of the Jacobian at q, and its rank.

    The generic rank is taken at a configuration near q, where all joints differ a little.
    """
    perturbation = 0.1 * np.sin(1.0 + np.arange(manifold.num_velocities))
    both = np.stack([q, manifold.plus(q, perturbation)])
    values, perturbed_values = np.linalg.svd(kinematics.jacobians(both), compute_uv=False)
    rank = int((perturbed_values > _ZERO_SINGULAR_VALUE).sum())
    return (float(values[rank - 1]) if rank else 0.0), rank


def _limit_margin(world: World, group: JointGroup, q: Array) -> float:
    """Return the smallest distance of a joint to its limits [rad or m]."""
    limits = world.limits(group)
    return float(np.minimum(q - limits.lower, limits.upper - q).min())


def _joint_outside(world: World, group: JointGroup, q: Array) -> str:
    """Return the name of the position farthest outside its limits, or else nearest to them."""
    limits = world.limits(group)
    return group.position_names[int(np.argmax(np.maximum(limits.lower - q, q - limits.upper)))]


def _worst_pair(world: World, group: JointGroup, q: Array, margins: PairMargins) -> BodyPair | None:
    """Return the body pair with the largest margin violation, or else nearest to one.

    Distances are approximate where boxes nearly touch: the collision check may be slightly
    stricter.
    """
    radius = margins.largest + _INFLUENCE_DISTANCE
    pairs = world.distance_probe(margins).pairs_within(world.embed(group, q), radius)
    return max(pairs, key=lambda pair: margins.of(*pair.bodies) - pair.distance, default=None)


def stop_evidence(stop: LineStop, margins: PairMargins) -> dict[str, Any]:
    """Return a line stop as evidence of a failure."""
    return {
        "reason": stop.reason,
        "fraction": stop.fraction,
        "where": {
            "position": stop.where.position.tolist(),
            "quaternion": stop.where.quaternion.tolist(),
        },
        "positions": stop.positions.tolist(),
        "joint": stop.joint,
        "pair": pair_evidence((stop.pair,), margins)[0] if stop.pair else None,
        "singular_value": stop.singular_value,
    }


def describe_stop(stop: LineStop) -> str:
    """Return a line stop as text for a message."""
    match stop.reason:
        case "limit":
            why = f"{stop.joint} would leave its limits"
        case "collision":
            bodies = "two bodies" if stop.pair is None else " and ".join(stop.pair.bodies)
            why = f"{bodies} would violate their margin"
        case "singularity":
            why = f"the arm is singular (smallest singular value {stop.singular_value:.2g})"
        case "unreachable":
            why = "the joints cannot move the tool in this direction"
    return f"it ends after {100 * stop.fraction:.2f} %: {why}"
