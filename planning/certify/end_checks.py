"""Form, ends and continuity of a trajectory."""

from typing import Any

import numpy as np

from planning.certify.request import CertifyRequest
from planning.domain.certificate import Check

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Deviation of configurations that counts as none [rad or m].
SAME = 1e-6
_SLOW = 1e-6
_RATE_JUMP = 1e-5
_MAX_ACCELERATION_JUMP = 1e-3


def form_check(request: CertifyRequest) -> Check:
    """Return whether the numbers are a trajectory at all: finite, ordered, of matching shapes."""
    curve = request.trajectory
    n, nq, nv = curve.num_pieces, request.group.num_positions, request.group.num_velocities
    faults: list[str] = []
    if curve.joints != request.group.joints:
        faults.append("its joints are not the group's")
    shapes = curve.breaks.shape, curve.bases.shape, curve.coefficients.shape[::2]
    if n == 0 or shapes != ((n + 1,), (n, nq), (n, nv)):
        faults.append(f"shapes {shapes} do not fit {n} pieces of {nq} positions")
    arrays = curve.breaks, curve.bases, curve.coefficients
    if not all(np.isfinite(array).all() for array in arrays):
        faults.append("a number is not finite")
    elif not faults and not (curve.breaks[0] == 0 and (np.diff(curve.breaks) > 0).all()):
        faults.append("its times do not increase from 0")
    elif not faults and _unit_fault(curve.bases, curve.manifold.normalized(curve.bases)) > 1e-9:
        faults.append("a quaternion is not of unit length")
    return Check("form", float(len(faults)), 0.0, "faults", 0.0, not faults, "; ".join(faults))


def start_check(request: CertifyRequest) -> Check:
    """Return how far from the wanted start the motion begins."""
    distance = _distance(request, request.trajectory.start, request.start)
    return Check("start", distance, SAME, "rad or m", 0.0, distance <= SAME)


def goal_check(request: CertifyRequest) -> Check:
    """Return how far from the nearest goal configuration the motion ends."""
    end = request.trajectory.end
    distance = min(_distance(request, end, goal) for goal in request.goals)
    time = request.trajectory.duration
    return Check("goal", distance, SAME, "rad or m", 0.0, distance <= SAME, "", time)


def rest_check(request: CertifyRequest) -> Check:
    """Return the largest speed at both ends."""
    curve = request.trajectory
    ends = np.array([0.0, curve.duration])
    speeds = np.abs(curve.tangents(ends, 1)).max(axis=1)
    worst = int(np.argmax(speeds))
    speed = float(speeds[worst])
    return Check("rest", speed, _SLOW, "rad/s or m/s", 0.0, speed <= _SLOW, "", float(ends[worst]))


def continuity_checks(request: CertifyRequest) -> list[Check]:
    """Return the largest jumps of position, velocity and, if jerk is limited, acceleration."""
    curve = request.trajectory
    if curve.num_pieces == 1:
        return [Check("continuity", 0.0, SAME, "rad or m", 0.0, passed=True)]
    before, after = _both_sides(request)
    jumps = curve.manifold.distance(after[0], before[0])
    checks = [_jump("continuity", jumps, SAME, "rad or m", curve.breaks)]
    rates = np.abs(after[1] - before[1]).max(axis=1)
    bound = _RATE_JUMP * float(request.limits.velocity.max())
    checks.append(_jump("velocity continuity", rates, bound, "rad/s or m/s", curve.breaks))
    if request.jerk:
        jumps = np.abs(after[2] - before[2]).max(axis=1)
        bound = _MAX_ACCELERATION_JUMP * float(request.limits.acceleration.max())
        name = "acceleration continuity"
        checks.append(_jump(name, jumps, bound, "rad/s^2 or m/s^2", curve.breaks))
    return checks


def _both_sides(request: CertifyRequest) -> tuple[list[Array], list[Array]]:
    """Return q, v and vdot just before and just after every interior break."""
    curve = request.trajectory
    widths = np.diff(curve.breaks)
    sides: list[list[Array]] = []
    for pieces, local in (
        (slice(None, -1), widths[:-1]),
        (slice(1, None), np.zeros(curve.num_pieces - 1)),
    ):
        values = [_evaluate(curve.coefficients[pieces], local, order) for order in range(3)]
        q = curve.manifold.plus(curve.bases[pieces], values[0])
        v = curve.manifold.generalized_velocity(q, *values[:2])
        vdot = curve.manifold.generalized_acceleration(q, *values)
        sides.append([q, v, vdot])
    return sides[0], sides[1]


def _evaluate(coefficients: Array, x: Array, order: int) -> Array:
    for _ in range(order):
        powers = np.arange(1, coefficients.shape[1], dtype=np.float64)
        coefficients = coefficients[:, 1:] * powers[None, :, None]
    powers = x[:, None] ** np.arange(coefficients.shape[1])
    return np.einsum("nk,nkv->nv", powers, coefficients)


def _jump(name: str, jumps: Array, bound: float, unit: str, breaks: Array) -> Check:
    worst = int(np.argmax(jumps))
    value = float(jumps[worst])
    return Check(name, value, bound, unit, 0.0, value <= bound, "", float(breaks[worst + 1]))


def _distance(request: CertifyRequest, q1: Array, q0: Array) -> float:
    return float(np.abs(request.trajectory.manifold.minus(q1, q0)).max())


def _unit_fault(q: Array, normalized: Array) -> float:
    return float(np.abs(q - normalized).max())
