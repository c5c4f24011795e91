"""Joint constraint checks: locked joints and tightened limits, from trajectory polynomials."""

import numpy as np

from planning.certify.intervals import bernstein
from planning.certify.request import CertifyRequest
from planning.domain.geometry import rotation
from planning.domain.report.certificate import Check
from planning.domain.request.constraint import LockedJoints, TightLimits
from planning.domain.robot.joints import Joint, JointType

# Tolerance of locked joints and of bounds [rad or m].
_TOLERANCE = 1e-6


def lock_check(name: str, constraint: LockedJoints, request: CertifyRequest) -> Check:
    """Return the check of the largest motion of locked joints from the start (guaranteed bound)."""
    worst = Check(name, 0.0, _TOLERANCE, "rad or m", 0.0, passed=True)
    iq = iv = 0
    for joint in request.group.joints:
        if joint.name in constraint.joints:
            deviation, piece = _max_deviation(request, joint, iq, iv)
            if not deviation <= worst.value:
                time = float(request.trajectory.breaks[piece])
                worst = Check(
                    name,
                    deviation,
                    _TOLERANCE,
                    "rad or m",
                    0.0,
                    deviation <= _TOLERANCE,
                    joint.name,
                    time,
                )
        iq += joint.num_positions
        iv += joint.num_velocities
    return worst


def tight_limits_check(name: str, constraint: TightLimits, request: CertifyRequest) -> Check:
    """Return the check of the largest excess over tightened bounds (guaranteed bound)."""
    curve, names = request.trajectory, request.group.position_names
    velocity_index, is_circular = _additive_coordinates(request.group.joints)
    worst = Check(name, -np.inf, _TOLERANCE, "rad or m", 0.0, passed=True)
    for coordinate, (low, high) in constraint.limits.items():
        iq = names.index(coordinate)
        if iq not in velocity_index:
            excesses = np.full((1, 1), np.inf)
        else:
            bases = curve.bases[:, iq]
            if is_circular[iq]:
                turns = np.round((bases - (low + high) / 2) / (2 * np.pi))
                bases = bases - 2 * np.pi * turns
            values = request.bernstein_forms[0][velocity_index[iq]] + bases[:, None]
            rounding_error = request.rounding_errors[0][velocity_index[iq]]
            excesses = np.concatenate([
                values - (high - rounding_error),
                (low + rounding_error) - values,
            ])
        peak, row, fraction = bernstein.peak(np.ascontiguousarray(excesses), _TOLERANCE / 100)
        if not peak <= worst.value:
            piece = row % curve.num_pieces
            begin, end = curve.breaks[piece], curve.breaks[piece + 1]
            time = float(begin + fraction * (end - begin))
            worst = Check(
                name, peak, _TOLERANCE, "rad or m", 0.0, peak <= _TOLERANCE, coordinate, time
            )
    return worst


def _max_deviation(request: CertifyRequest, joint: Joint, iq: int, iv: int) -> tuple[float, int]:
    """Return the largest motion of a joint from the start, in any coordinate, and the piece."""
    curve, start = request.trajectory, request.reference
    tangents = request.bernstein_forms[0][iv : iv + joint.num_velocities]
    if joint.type is JointType.FLOATING:
        inverse = rotation.conjugate(start[iq : iq + 4])
        base_rotations = rotation.log(rotation.multiply(inverse, curve.bases[:, iq : iq + 4]))
        tangent_rotations = np.linalg.norm(tangents[:3], axis=0).max(axis=1)
        rotations = np.linalg.norm(base_rotations, axis=1) + tangent_rotations
        base_translations = curve.bases[:, iq + 4 : iq + 7] - start[iq + 4 : iq + 7]
        translations = np.abs(tangents[3:] + base_translations.T[:, :, None]).max(axis=(0, 2))
        deviations = np.maximum(rotations, translations)
    else:
        base_offsets = (
            curve.bases[:, iq : iq + joint.num_positions] - start[iq : iq + joint.num_positions]
        )
        deviations = np.abs(tangents + base_offsets.T[:, :, None]).max(axis=(0, 2))
    piece = int(np.argmax(deviations))
    rounding_error = np.linalg.norm(request.rounding_errors[0][iv : iv + joint.num_velocities])
    return float(deviations[piece] + rounding_error), piece


def _additive_coordinates(joints: tuple[Joint, ...]) -> tuple[dict[int, int], dict[int, bool]]:
    """Return the index in v by index in q of additive coordinates, and which are circular."""
    velocity_index: dict[int, int] = {}
    is_circular: dict[int, bool] = {}
    iq = iv = 0
    for joint in joints:
        skip = (4, 3) if joint.type is JointType.FLOATING else (0, 0)
        for k in range(joint.num_positions - skip[0]):
            velocity_index[iq + skip[0] + k] = iv + skip[1] + k
            is_circular[iq + skip[0] + k] = joint.wraps[skip[1] + k]
        iq += joint.num_positions
        iv += joint.num_velocities
    return velocity_index, is_circular
