"""Ends of a trajectory, and what happens where its pieces meet."""

from typing import Any

import numpy as np

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
    distance = _distance(request, _at_begins(request, 0)[0], request.start)
    return Check("start", distance, SAME, "rad or m", 0.0, distance <= SAME)


def goal_check(request: CertifyRequest) -> Check:
    """Return how far from the nearest goal configuration the motion ends."""
    end = _at_ends(request, 0)[-1]
    distance = min(_distance(request, end, goal) for goal in request.goals)
    time = request.trajectory.duration
    return Check("goal", distance, SAME, "rad or m", 0.0, distance <= SAME, "", time)


def rest_check(request: CertifyRequest) -> Check:
    """Return the largest speed at both ends; at the last alone, if it begins under way."""
    rates, duration = request.forms[1], request.trajectory.duration
    first, last = float(np.abs(rates[:, 0, 0]).max()), float(np.abs(rates[:, -1, -1]).max())
    is_first = first >= last and request.origin is None
    speed, time = (first, 0.0) if is_first else (last, duration)
    return Check("rest", speed, _SLOW, "rad/s or m/s", 0.0, speed <= _SLOW, "", time)


def continuity_checks(request: CertifyRequest) -> list[Check]:
    """Return the largest jumps of position and velocity between pieces.

    If jerk is limited, those of acceleration as well, from and to rest included: a step there would
    be an infinite jerk. What begins under way has whatever acceleration it begins with.
    """
    curve = request.trajectory
    between = curve.breaks[1:-1]
    sides = [(_at_begins(request, order)[1:], _at_ends(request, order)[:-1]) for order in range(2)]
    jumps = curve.manifold.distance(*sides[0])
    checks = [_jump("continuity", jumps, SAME, "rad or m", between)]
    shares = _shares(request, sides[1][0] - sides[1][1], request.limits.velocity)
    checks.append(_jump("velocity continuity", shares, _RATE_JUMP, "1", between))
    if request.jerk:
        after, before = _at_begins(request, 2), _at_ends(request, 2)
        first = after[:1] if request.origin is None else np.zeros_like(after[:1])
        steps = np.concatenate([first, after[1:] - before[:-1], before[-1:]])
        shares = _shares(request, steps, request.limits.acceleration)
        name = "acceleration continuity"
        checks.append(_jump(name, shares, _ACCELERATION_JUMP, "1", curve.breaks))
    return checks


def _at_begins(request: CertifyRequest, order: int) -> Array:
    """Return q (0), v (1) or vdot (2) where every piece begins, a row for each."""
    return _states(request, order, 0)


def _at_ends(request: CertifyRequest, order: int) -> Array:
    """Return the same where every piece ends."""
    return _states(request, order, -1)


def _states(request: CertifyRequest, order: int, which: int) -> Array:
    curve = request.trajectory
    values = [form[:, :, which].T for form in request.forms[: order + 1]]
    q = curve.manifold.plus(curve.bases, values[0])
    match order:
        case 0:
            return q
        case 1:
            return curve.manifold.generalized_velocity(q, *values)
        case _:
            return curve.manifold.generalized_acceleration(q, *values)


def _shares(request: CertifyRequest, steps: Array, limits: Array) -> Array:
    """Return the largest step of any block over its limit; what has no limit counts as it is."""
    bounds = np.where(np.isfinite(limits), limits, 1.0)
    blocks = [list(indices) for _, indices in request.group.blocks]
    if all(len(block) == 1 for block in blocks):
        return np.abs(steps[:, [block[0] for block in blocks]] / bounds).max(axis=1)
    sizes = np.stack([np.linalg.norm(steps[:, block], axis=1) for block in blocks], axis=1)
    return (sizes / bounds).max(axis=1)


def _jump(name: str, jumps: Array, bound: float, unit: str, times: Array) -> Check:
    if len(jumps) == 0:
        return Check(name, 0.0, bound, unit, 0.0, passed=True)
    worst = int(np.argmax(jumps))
    value = float(jumps[worst])
    return Check(name, value, bound, unit, 0.0, value <= bound, "", float(times[worst]))


def _distance(request: CertifyRequest, q1: Array, q0: Array) -> float:
    return float(np.abs(request.trajectory.manifold.minus(q1, q0)).max())
