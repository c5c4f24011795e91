"""End checks: start, goal and rest of a trajectory, and continuity where its pieces meet."""

import numpy as np

from planning.certify.intervals.jumps import JumpSums, position_jumps
from planning.certify.joints.joint_bounds import JointJumps
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.report.certificate import Check

# Tolerance for equal configurations, of follower joints too [rad or m].
CONFIGURATION_TOLERANCE = 1e-6
# Speed that counts as rest [rad/s or m/s].
_REST_SPEED = 1e-6
# Tolerance for sums of jumps in rates, as a share of the limit: rounding. A jump of acceleration
# this small is less than the change in 0.1 ms under a jerk limit of ten times the acceleration per
# second.
_RATE_JUMP_TOLERANCE = 1e-5
_ACCELERATION_JUMP_TOLERANCE = 1e-3


def start_check(request: CertifyRequest) -> Check:
    """Return the check of the distance between the motion's first and the required start."""
    distance = _distance(request, _states(request, 0, 0, slice(1))[0], request.start[None])
    return Check(
        "start",
        distance,
        CONFIGURATION_TOLERANCE,
        "rad or m",
        0.0,
        distance <= CONFIGURATION_TOLERANCE,
    )


def goal_check(request: CertifyRequest) -> Check:
    """Return the check of the distance between the motion's end and the nearest goal."""
    end = _states(request, 0, -1, slice(-1, None))[0]
    distance = _distance(request, end, request.goals)
    time = request.trajectory.duration
    return Check(
        "goal",
        distance,
        CONFIGURATION_TOLERANCE,
        "rad or m",
        0.0,
        distance <= CONFIGURATION_TOLERANCE,
        "",
        time,
    )


def rest_check(request: CertifyRequest) -> Check:
    """Return the check of the speed at both ends; at the last alone if the motion begins moving."""
    rates, duration = request.bernstein_forms[1], request.trajectory.duration
    ends = [rates[:, i, i] * request.follower_ratios for i in (0, -1)]
    first, last = (float(np.abs(speeds).max()) for speeds in ends)
    is_first = first >= last and request.origin is None
    speed, time = (first, 0.0) if is_first else (last, duration)
    return Check("rest", speed, _REST_SPEED, "rad/s or m/s", 0.0, speed <= _REST_SPEED, "", time)


def continuity_checks(request: CertifyRequest) -> list[Check]:
    """Return the checks of the largest sums of position and velocity jumps between pieces.

    If jerk is limited, jumps of acceleration are checked as well, from and to rest included: a step
    there would be an infinite jerk. A motion that begins moving may begin with any acceleration.
    """
    limits, times = request.limits_with_followers, request.trajectory.breaks
    between = times[1:-1]
    position_sums, velocity_sums = _jump_sums(request)
    distance = float(np.linalg.norm(position_sums.largest))
    time = _time(between, position_sums, int(np.argmax(position_sums.largest)))
    checks = [_jump("continuity", distance, CONFIGURATION_TOLERANCE, "rad or m", time)]
    name = "velocity continuity"
    checks.append(
        _rate_jump(request, name, (velocity_sums, limits.velocity), _RATE_JUMP_TOLERANCE, between)
    )
    if request.jerk:
        sums_and_limits = _acceleration_jump_sums(request), limits.acceleration
        name = "acceleration continuity"
        checks.append(
            _rate_jump(request, name, sums_and_limits, _ACCELERATION_JUMP_TOLERANCE, times)
        )
    return checks


def _jump_sums(request: CertifyRequest) -> tuple[JumpSums | JointJumps, JumpSums | JointJumps]:
    """Return the sums of jumps of positions, and of velocities, where pieces meet."""
    if request.joint_bounds is not None:
        return request.joint_bounds.jumps[0], request.joint_bounds.jumps[1]
    begins, ends = _at_begins(request, 0), _at_ends(request, 0)
    jumps = position_jumps(request.trajectory, begins, ends)
    steps = _at_begins(request, 1)[1:] - _at_ends(request, 1)[:-1]
    all_jumps = np.concatenate([jumps * request.follower_ratios, steps], axis=1)
    return JumpSums.of(all_jumps).split(steps.shape[1])


def _acceleration_jump_sums(request: CertifyRequest) -> JumpSums | JointJumps:
    """Return the sums of jumps of accelerations, those from and to rest included."""
    if request.joint_bounds is not None and request.origin is None:
        return request.joint_bounds.jumps[2]
    after, before = _at_begins(request, 2), _at_ends(request, 2)
    first = after[:1] if request.origin is None else np.zeros_like(after[:1])
    return JumpSums.of(np.concatenate([first, after[1:] - before[:-1], -before[-1:]]))


def _at_begins(request: CertifyRequest, order: int) -> Array:
    """Return q (0), v (1) or vdot (2) at the beginning of every piece, one row per piece."""
    return _states(request, order, 0)


def _at_ends(request: CertifyRequest, order: int) -> Array:
    """Return q (0), v (1) or vdot (2) at the end of every piece, one row per piece."""
    return _states(request, order, -1)


def _states(request: CertifyRequest, order: int, index: int, rows: slice = slice(None)) -> Array:
    curve = request.trajectory
    values = [form[:, rows, index].T for form in request.bernstein_forms[: order + 1]]
    if order and curve.manifold.is_flat:
        return values[order]
    q = curve.manifold.plus(curve.bases[rows], values[0])
    match order:
        case 0:
            return q
        case 1:
            return curve.manifold.generalized_velocity(q, *values)
        case _:
            return curve.manifold.generalized_acceleration(q, *values)


def _rate_jump(
    request: CertifyRequest,
    name: str,
    sums_and_limits: tuple[JumpSums | JointJumps, Array],
    bound: float,
    times: Array,
) -> Check:
    """Return the check of the largest sum of a block's jumps over its limit, if it has one.

    Without a limit the sum itself is compared.
    """
    sums, limits = sums_and_limits
    blocks, sizes = request.group.blocks, sums.largest
    if len(blocks) < len(sizes):
        sizes = np.array([np.linalg.norm(sizes[list(block)]) for _, block in blocks])
    utilizations = sizes / np.where(np.isfinite(limits), limits, 1.0)
    worst = int(np.argmax(utilizations))
    columns = blocks[worst][1]
    column = max(columns, key=lambda i: sums.largest[i])
    return _jump(name, float(utilizations[worst]), bound, "1", _time(times, sums, column))


def _jump(name: str, value: float, bound: float, unit: str, time: float) -> Check:
    return Check(name, value, bound, unit, 0.0, value <= bound, "", time)


def _time(times: Array, sums: JumpSums | JointJumps, column: int) -> float:
    """Return the instant [s] at which the largest sum of a coordinate's jumps is complete, or 0."""
    return float(times[sums.last_jump(column)]) if len(times) else 0.0


def _distance(request: CertifyRequest, q: Array, goals: Array) -> float:
    """Return the largest difference of a coordinate of q, shape (nq,), from the nearest goal."""
    differences = request.trajectory.manifold.minus(q, goals) * request.follower_ratios
    return float(np.abs(differences).max(axis=1).min())
