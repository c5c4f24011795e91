"""Seeds: initial guesses of the IK solvers: the start, samples near it, then uniform samples."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointLimits, JointType
from planning.domain.robot.manifold import Manifold

_NUM_NEAR = 8
_NEAR = 0.4
_REACH = 2.0
_AT_ONCE = 256


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
        delta = rng.normal(0.0, _NEAR, (_NUM_NEAR, self._manifold.num_velocities))
        near = np.clip(self._manifold.plus(start[None], delta), limits.lower, limits.upper)
        self._waiting = np.concatenate([start[None], near])
        reach = np.concatenate([_spread(joint.type) for joint in group.joints])
        self._lower = np.where(np.isfinite(limits.lower), limits.lower, start - reach)
        self._upper = np.where(np.isfinite(limits.upper), limits.upper, start + reach)
        self._turned = np.concatenate([_is_quaternion(joint.type) for joint in group.joints])

    def take(self, count: int) -> Float64[np.ndarray, "count nq"]:
        """Return the next `count` seeds."""
        if len(self._waiting) < count:
            drawn = self._drawn(_AT_ONCE * -(-(count - len(self._waiting)) // _AT_ONCE))
            self._waiting = np.concatenate([self._waiting, drawn])
        taken, self._waiting = self._waiting[:count], self._waiting[count:]
        return taken

    def _drawn(self, count: int) -> Array:
        """Return `count` uniform seeds, drawn in blocks of a fixed size for reproducibility."""
        portions: list[Array] = []
        for _ in range(count // _AT_ONCE):
            q = self._rng.uniform(self._lower, self._upper, (_AT_ONCE, len(self._lower)))
            q[:, self._turned] = self._rng.normal(size=(_AT_ONCE, int(self._turned.sum())))
            portions.append(q)
        return self._manifold.normalized(np.concatenate(portions))


def _spread(kind: JointType) -> Array:
    match kind:
        case JointType.PLANAR:
            return np.array([_REACH, _REACH, np.pi])
        case JointType.FLOATING:
            return np.array([1.0, 1.0, 1.0, 1.0, _REACH, _REACH, _REACH])
        case JointType.PRISMATIC:
            return np.array([_REACH])
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
