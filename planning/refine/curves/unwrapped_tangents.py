"""Unwrapped tangents: coordinates at a base along a path, without jumps at half a turn.

exp(phi) is the same rotation for phi and (1 + 2 pi k / |phi|) phi, full turns apart.
"""

import numpy as np
from jaxtyping import Float64, Int

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointType, offsets_of
from planning.domain.robot.manifold import Manifold

_FULL_TURN = 2 * np.pi
# Smallest divisor: below it the axis of a rotation does not matter [rad].
_TINY = 1e-12


def rotation_angles(
    group: JointGroup, deltas: Float64[np.ndarray, "*n nv"]
) -> Float64[np.ndarray, "*n k"]:
    """Return the rotation angle of each floating joint [rad]."""
    rotations = [deltas[..., i : i + 3] for i in _rotation_offsets(group)]
    return np.stack([np.linalg.norm(rotation, axis=-1) for rotation in rotations], axis=-1)


def tangents_along(
    group: JointGroup, qs: Float64[np.ndarray, "n nq"], anchors: Int[np.ndarray, " b"]
) -> Float64[np.ndarray, "n b nv"]:
    """Return continuous delta with qs[anchor] [+] delta = q along a path, zero at each anchor.

    Args:
        group: The joints.
        qs: Configurations along a path, consecutive ones near each other.
        anchors: Rows of those that are bases.
    """
    tangents = Manifold(group.joints).minus(qs[:, None], qs[anchors][None])
    for i in range(1, len(qs)):
        is_after = anchors < i
        tangents[i, is_after] = _nearest_equivalent(
            group, tangents[i, is_after], tangents[i - 1, is_after]
        )
    for i in range(len(qs) - 2, -1, -1):
        is_before = anchors > i
        tangents[i, is_before] = _nearest_equivalent(
            group, tangents[i, is_before], tangents[i + 1, is_before]
        )
    return tangents


def _nearest_equivalent(group: JointGroup, deltas: Array, references: Array) -> Array:
    """Return the tangents of the same configurations that are nearest to others."""
    nearest = np.array(deltas)
    wrapping = list(Manifold(group.joints).wraps)
    nearest[:, wrapping] += _FULL_TURN * np.round((references - deltas)[:, wrapping] / _FULL_TURN)
    for i in _rotation_offsets(group):
        rotation = deltas[:, i : i + 3]
        length = np.linalg.norm(rotation, axis=1, keepdims=True)
        axis = rotation / np.maximum(length, _TINY)
        along = np.sum(axis * references[:, i : i + 3], axis=1, keepdims=True)
        nearest[:, i : i + 3] += _FULL_TURN * np.round((along - length) / _FULL_TURN) * axis
    return nearest


def _rotation_offsets(group: JointGroup) -> list[int]:
    """Return the index in v of the rotation of each floating joint."""
    return [iv for _, iv in offsets_of(group.joints, lambda j: j.type is JointType.FLOATING)]
