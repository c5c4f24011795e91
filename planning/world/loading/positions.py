"""Validation of given positions of a group."""

from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointType
from planning.domain.robot.manifold import Manifold
from planning.errors import ProblemInvalid

# Length of a quaternion below which it has no direction.
_MIN_QUATERNION_NORM = 1e-6


def validate_positions(group: JointGroup, q: Any, field: str) -> Array:
    """Return q as the group's positions, read-only and with unit quaternions.

    Args:
        group: Group of the positions.
        q: Numbers [rad or m].
        field: Name of the positions in messages.

    Raises:
        ProblemInvalid: The count is wrong, a number is not finite, or a quaternion is zero.
    """
    positions = np.array(q, dtype=np.float64)
    if positions.shape != (group.num_positions,):
        names = list(group.position_names)
        message = f"{field}: {group.name} has {len(names)} positions {names}, got {positions.size}"
        raise ProblemInvalid(message, {"field": field, "expected": names, "got": positions.size})
    if not np.isfinite(positions).all():
        named = zip(group.position_names, positions, strict=True)
        bad = [name for name, x in named if not np.isfinite(x)]
        message = f"{field}: {bad} must be finite"
        raise ProblemInvalid(message, {"field": field, "joints": bad})
    if group.has_scalar_joints:
        positions.flags.writeable = False
        return positions
    _validate_quaternions(group, positions, field)
    unit = Manifold.of(group.joints).normalized(positions)
    unit.flags.writeable = False
    return unit


def _validate_quaternions(group: JointGroup, positions: Array, field: str) -> None:
    begin = 0
    for joint in group.joints:
        is_floating = joint.type is JointType.FLOATING
        if is_floating and np.linalg.norm(positions[begin : begin + 4]) < _MIN_QUATERNION_NORM:
            message = f"{field}: the quaternion [w, x, y, z] of {joint.name} must not be zero"
            raise ProblemInvalid(message, {"field": field, "joints": [joint.name]})
        begin += joint.num_positions
