"""Joint constraint checks: locked joints and tightened limits, from trajectory polynomials."""

import numpy as np

from planning.certify.intervals import bernstein
from planning.certify.request import CertifyRequest
from planning.domain.geometry import rotation
from planning.domain.report.certificate import Check
from planning.domain.request.constraint import LockedJoints, TightLimits
from planning.domain.robot.joints import Joint, JointType

# Tolerance of locked joints and of bounds [rad or m].
_DUST = 1e-6


def lock_check(name: str, constraint: LockedJoints, request: CertifyRequest) -> Check:
    """Return the check of the largest motion of locked joints from the start (guaranteed bound)."""
    worst = Check(name, 0.0, _DUST, "rad or m", 0.0, passed=True)
    iq = iv = 0
    for joint in request.group.joints:
        if joint.name in constraint.joints:
            away, piece = _away(request, joint, iq, iv)
            if not away <= worst.value:
                time = float(request.trajectory.breaks[piece])
                worst = Check(name, away, _DUST, "rad or m", 0.0, away <= _DUST, joint.name, time)
        iq += joint.num_positions
        iv += joint.num_velocities
    return worst


def tight_check(name: str, constraint: TightLimits, request: CertifyRequest) -> Check:
    """Return the check of the largest excess over tightened bounds (guaranteed bound)."""
    curve, names = request.trajectory, request.group.position_names
    to_v, circle = _plain(request.group.joints)
    worst = Check(name, -np.inf, _DUST, "rad or m", 0.0, passed=True)
    for coordinate, (low, high) in constraint.limits.items():
        iq = names.index(coordinate)
        if iq not in to_v:
            excesses = np.full((1, 1), np.inf)
        else:
            bases = curve.bases[:, iq]
            if circle[iq]:
                turns = np.round((bases - (low + high) / 2) / (2 * np.pi))
                bases = bases - 2 * np.pi * turns
            values = request.forms[0][to_v[iq]] + bases[:, None]
            hidden = request.rounding[0][to_v[iq]]
            excesses = np.concatenate([values - (high - hidden), (low + hidden) - values])
        top, row, fraction = bernstein.peak(np.ascontiguousarray(excesses), _DUST / 100)
        if not top <= worst.value:
            piece = row % curve.num_pieces
            begin, end = curve.breaks[piece], curve.breaks[piece + 1]
            time = float(begin + fraction * (end - begin))
            worst = Check(name, top, _DUST, "rad or m", 0.0, top <= _DUST, coordinate, time)
    return worst


def _away(request: CertifyRequest, joint: Joint, iq: int, iv: int) -> tuple[float, int]:
    """Return the largest motion of a joint from the start, in any coordinate, and the piece."""
    curve, start = request.trajectory, request.reference
    moves = request.forms[0][iv : iv + joint.num_velocities]
    if joint.type is JointType.FLOATING:
        inverse = rotation.conjugate(start[iq : iq + 4])
        turn = rotation.log(rotation.multiply(inverse, curve.bases[:, iq : iq + 4]))
        own = np.linalg.norm(moves[:3], axis=0).max(axis=1)
        turned = np.linalg.norm(turn, axis=1) + own
        shift = curve.bases[:, iq + 4 : iq + 7] - start[iq + 4 : iq + 7]
        shifted = np.abs(moves[3:] + shift.T[:, :, None]).max(axis=(0, 2))
        away = np.maximum(turned, shifted)
    else:
        off = curve.bases[:, iq : iq + joint.num_positions] - start[iq : iq + joint.num_positions]
        away = np.abs(moves + off.T[:, :, None]).max(axis=(0, 2))
    piece = int(np.argmax(away))
    hidden = np.linalg.norm(request.rounding[0][iv : iv + joint.num_velocities])
    return float(away[piece] + hidden), piece


def _plain(joints: tuple[Joint, ...]) -> tuple[dict[int, int], dict[int, bool]]:
    """Return the index in v by index in q of additive coordinates, and which are circular."""
    to_v: dict[int, int] = {}
    circle: dict[int, bool] = {}
    iq = iv = 0
    for joint in joints:
        skip = (4, 3) if joint.type is JointType.FLOATING else (0, 0)
        for k in range(joint.num_positions - skip[0]):
            to_v[iq + skip[0] + k] = iv + skip[1] + k
            circle[iq + skip[0] + k] = joint.wraps[skip[1] + k]
        iq += joint.num_positions
        iv += joint.num_velocities
    return to_v, circle
