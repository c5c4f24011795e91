"""Seeds for the solver: the start, its neighbourhood, then anywhere."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.joints import JointGroup, JointLimits, JointType
from planning.domain.manifold import Manifold

type Array = np.ndarray[Any, np.dtype[np.float64]]

_NUM_NEAR = 8
_NEAR = 0.4
_REACH = 2.0


def seeds(
    group: JointGroup,
    limits: JointLimits,
    start: Float64[np.ndarray, " nq"],
    rng: np.random.Generator,
) -> Iterator[Array]:
    """Yield configurations to solve from, each shape (nq,), without end.

    Coordinates without bounds are drawn within half a turn, or within 2 m of the start.
    """
    manifold = Manifold(group.joints)
    yield start
    for _ in range(_NUM_NEAR):
        delta = rng.normal(0.0, _NEAR, manifold.num_velocities)
        yield np.clip(manifold.plus(start, delta), limits.lower, limits.upper)
    spread = [_spread(joint.type) for joint in group.joints]
    reach = np.concatenate(spread)
    lower = np.where(np.isfinite(limits.lower), limits.lower, start - reach)
    upper = np.where(np.isfinite(limits.upper), limits.upper, start + reach)
    turned = np.concatenate([_is_quaternion(joint.type) for joint in group.joints])
    while True:
        q = rng.uniform(lower, upper)
        q[turned] = rng.normal(size=int(turned.sum()))
        yield manifold.normalized(q)


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
