"""Ends of a trajectory, and what happens where its pieces meet."""

from typing import Any

import numpy as np

from planning.certify import bernstein
from planning.certify.request import CertifyRequest
from planning.domain.certificate import Check

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Deviation of configurations that counts as none [rad or m].
SAME = 1e-6
# Speed that counts as rest [rad/s or m/s].
_SLOW = 1e-6
# Jumps that count as rounding, as a share of the limit. A jump of acceleration this small is less
# than what a limit on jerk of ten times the acceleration per second does in 0.1 ms.
_RATE_JUMP = 1e-5
_ACCELERATION_JUMP = 1e-3


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
    """Return the largest jumps of position and velocity between pieces.

    If jerk is limited, those of acceleration as well, from and to rest included: a step there would
    be an infinite jerk.
    """
    curve = request.trajectory
    before, after = _both_sides(request)
    jumps = curve.manifold.distance(after[0], before[0])
    checks = [_jump("continuity", jumps, SAME, "rad or m", curve.breaks[1:-1])]
    shares = _shares(request, after[1] - before[1], request.limits.velocity)
    checks.append(_jump("velocity continuity", shares, _RATE_JUMP, "1", curve.breaks[1:-1]))
    if request.jerk:
        steps = after[2] - before[2]
        ends = _second_derivatives(request)
        steps = np.concatenate([ends[:1], steps, ends[1:]])
        shares = _shares(request, steps, request.limits.acceleration)
        name = "acceleration continuity"
        checks.append(_jump(name, shares, _ACCELERATION_JUMP, "1", curve.breaks))
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


def _second_derivatives(request: CertifyRequest) -> Array:
    """Return vdot at the start and at the end."""
    return request.trajectory.accelerations(np.array([0.0, request.trajectory.duration]))


def _evaluate(coefficients: Array, x: Array, order: int) -> Array:
    coefficients = bernstein.derivative(coefficients, order)
    powers = x[:, None] ** np.arange(coefficients.shape[1])
    return np.einsum("nk,nkv->nv", powers, coefficients)


def _shares(request: CertifyRequest, steps: Array, limits: Array) -> Array:
    """Return the largest step of any block over its limit; what has no limit counts as it is."""
    shares = np.zeros(len(steps))
    for (_, indices), limit in zip(request.group.blocks, limits, strict=True):
        sizes = np.linalg.norm(steps[:, list(indices)], axis=1)
        shares = np.maximum(shares, sizes / (limit if np.isfinite(limit) else 1.0))
    return shares


def _jump(name: str, jumps: Array, bound: float, unit: str, times: Array) -> Check:
    if len(jumps) == 0:
        return Check(name, 0.0, bound, unit, 0.0, passed=True)
    worst = int(np.argmax(jumps))
    value = float(jumps[worst])
    return Check(name, value, bound, unit, 0.0, value <= bound, "", float(times[worst]))


def _distance(request: CertifyRequest, q1: Array, q0: Array) -> float:
    return float(np.abs(request.trajectory.manifold.minus(q1, q0)).max())
