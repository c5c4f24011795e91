"""Unwrapped tangents: coordinates at a base along a path, without jumps at half a turn.

exp(phi) is the same rotation for phi and (1 + 2 pi k / |phi|) phi, full turns apart.
"""

import numpy as np
from jaxtyping import Float64, Int

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointType, offsets_of
from planning.domain.robot.manifold import Manifold

_TURN = 2 * np.pi
_TINY = 1e-12


def turns_of(
    group: JointGroup, deltas: Float64[np.ndarray, "*n nv"]
) -> Float64[np.ndarray, "*n k"]:
    """Return the rotation angle of each floating joint [rad]."""
    spins = [deltas[..., i : i + 3] for i in _spins(group)]
    return np.stack([np.linalg.norm(spin, axis=-1) for spin in spins], axis=-1)


def tangents_along(
    group: JointGroup, qs: Float64[np.ndarray, "n nq"], anchors: Int[np.ndarray, " b"]
) -> Float64[np.ndarray, "n b nv"]:
    """Return continuous delta with qs[anchor] [+] delta = q along a path, zero at each anchor.

    Args:
        group: The joints.
        qs: Configurations along a path, consecutive ones near each other.
        anchors: Rows of those that are bases.
    """
    found = Manifold(group.joints).minus(qs[:, None], qs[anchors][None])
    for i in range(1, len(qs)):
        ahead = anchors < i
        found[i, ahead] = _nearest(group, found[i, ahead], found[i - 1, ahead])
    for i in range(len(qs) - 2, -1, -1):
        behind = anchors > i
        found[i, behind] = _nearest(group, found[i, behind], found[i + 1, behind])
    return found


def _nearest(group: JointGroup, deltas: Array, others: Array) -> Array:
    """Return the tangents of the same configurations that are nearest to others."""
    near = np.array(deltas)
    circle = list(Manifold(group.joints).wraps)
    near[:, circle] += _TURN * np.round((others - deltas)[:, circle] / _TURN)
    for i in _spins(group):
        spin = deltas[:, i : i + 3]
        length = np.linalg.norm(spin, axis=1, keepdims=True)
        axis = spin / np.maximum(length, _TINY)
        along = np.sum(axis * others[:, i : i + 3], axis=1, keepdims=True)
        near[:, i : i + 3] += _TURN * np.round((along - length) / _TURN) * axis
    return near


def _spins(group: JointGroup) -> list[int]:
    """Return the index in v of the rotation of each floating joint."""
    return [iv for _, iv in offsets_of(group.joints, lambda j: j.type is JointType.FLOATING)]
