"""Seeds: initial guesses of the IK solvers: the start, samples near it, then uniform samples."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointLimits, JointType
from planning.domain.robot.manifold import Manifold

# Number of samples near the start, and their standard deviation [rad or m].
_NUM_NEAR, _NEAR_DEVIATION = 8, 0.4
# Half-range of translations without bounds about the start [m].
_UNBOUNDED_RANGE = 2.0
# Uniform seeds per block.
_BATCH_SIZE = 256


class Seeds:
    """Endless sequence of seeds; it does not depend on how many are taken at once."""

    def __init__(
        self,
        group: JointGroup,
        limits: JointLimits,
        start: Float64[np.ndarray, " nq"],
        rng: np.random.Generator,
    ) -> None:
        """Begin the sequence with the start.

        Coordinates without bounds are drawn within half a turn, or within 2 m, of the start.
        """
        self._rng = rng
        self._manifold = Manifold(group.joints)
        delta = rng.normal(0.0, _NEAR_DEVIATION, (_NUM_NEAR, self._manifold.num_velocities))
        near = np.clip(self._manifold.plus(start[None], delta), limits.lower, limits.upper)
        self._pending = np.concatenate([start[None], near])
        self._num_quaternion_numbers = 0
        if group.has_scalar_joints and np.isfinite([limits.lower, limits.upper]).all():
            self._lower, self._upper = limits.lower, limits.upper
            return
        half_range = np.concatenate([_default_range(joint.type) for joint in group.joints])
        self._lower = np.where(np.isfinite(limits.lower), limits.lower, start - half_range)
        self._upper = np.where(np.isfinite(limits.upper), limits.upper, start + half_range)
        self._quaternion_mask = np.concatenate([
            _is_quaternion(joint.type) for joint in group.joints
        ])
        self._num_quaternion_numbers = int(self._quaternion_mask.sum())

    def take(self, count: int) -> Float64[np.ndarray, "count nq"]:
        """Return the next `count` seeds."""
        if len(self._pending) < count:
            new_seeds = self._draw(_BATCH_SIZE * -(-(count - len(self._pending)) // _BATCH_SIZE))
            self._pending = np.concatenate([self._pending, new_seeds])
        taken, self._pending = self._pending[:count], self._pending[count:]
        return taken

    def _draw(self, count: int) -> Array:
        """Return `count` uniform seeds, drawn in blocks of a fixed size for reproducibility."""
        blocks: list[Array] = []
        for _ in range(count // _BATCH_SIZE):
            # As `uniform` of both bounds, which takes four times as long.
            q = self._rng.random((_BATCH_SIZE, len(self._lower)))
            q = self._lower + (self._upper - self._lower) * q
            if self._num_quaternion_numbers:
                q[:, self._quaternion_mask] = self._rng.normal(
                    size=(_BATCH_SIZE, self._num_quaternion_numbers)
                )
            blocks.append(q)
        return self._manifold.normalized(np.concatenate(blocks))


def _default_range(kind: JointType) -> Array:
    match kind:
        case JointType.PLANAR:
            return np.array([_UNBOUNDED_RANGE, _UNBOUNDED_RANGE, np.pi])
        case JointType.FLOATING:
            return np.array([1.0] * 4 + [_UNBOUNDED_RANGE] * 3)
        case JointType.PRISMATIC:
            return np.array([_UNBOUNDED_RANGE])
        case _:
            return np.array([np.pi])


def _is_quaternion(kind: JointType) -> Any:
    match kind:
        case JointType.PLANAR:
            return np.zeros(3, dtype=bool)
        case JointType.FLOATING:
            return np.array([True] * 4 + [False] * 3)
        case _:
            return np.zeros(1, dtype=bool)
