"""Which configurations are distinct, which whole turns they have, and which come first."""

from itertools import product
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.joints import JointGroup, JointLimits, JointType
from planning.domain.manifold import Manifold

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Two configurations nearer than this in every joint are one and the same [rad or m].
SAME = 1e-3
_MAX_EQUIVALENTS = 4096


def is_new(
    group: JointGroup, q: Float64[np.ndarray, " nq"], known: list[tuple[int, Array]], target: int
) -> bool:
    """Return whether q differs, whole turns aside, from every known solution of that target."""
    manifold = Manifold(group.joints)
    others = [other for index, other in known if index == target]
    if not others:
        return True
    delta = manifold.minus(np.stack(others), q[None])
    turns = np.array(_turning(group))
    delta[:, turns] = np.remainder(delta[:, turns] + np.pi, 2 * np.pi) - np.pi
    return bool(np.abs(delta).max(axis=1).min() > SAME)


def equivalents(
    group: JointGroup, limits: JointLimits, q: Float64[np.ndarray, " nq"]
) -> Float64[np.ndarray, "n nq"]:
    """Return q with whole turns added to its revolute joints in every way within the limits.

    Continuous joints have none: a whole turn of theirs is the same point of the manifold.
    """
    choices: list[list[float]] = []
    names = [joint.type for joint in group.joints for _ in joint.position_names]
    for kind, x, low, high in zip(names, q, limits.lower, limits.upper, strict=True):
        if kind is not JointType.REVOLUTE:
            choices.append([float(x)])
            continue
        first = int(np.ceil((low - x) / (2 * np.pi) - 1e-12))
        last = int(np.floor((high - x) / (2 * np.pi) + 1e-12))
        turns = [float(x + 2 * np.pi * k) for k in range(first, last + 1)]
        choices.append([float(np.clip(turn, low, high)) for turn in turns] or [float(x)])
    count = int(np.prod([len(choice) for choice in choices]))
    if count > _MAX_EQUIVALENTS:
        return q[None]
    return np.array(list(product(*choices)))


def nearest_first(
    group: JointGroup,
    start: Float64[np.ndarray, " nq"],
    candidates: list[tuple[int, Array]],
    count: int,
) -> tuple[Array, tuple[int, ...]]:
    """Return the `count` candidates nearest to the start and their target indices."""
    rows = np.stack([q for _, q in candidates])
    distances = Manifold(group.joints).distance(rows, start[None])
    order = np.argsort(distances, kind="stable")[:count]
    return rows[order], tuple(candidates[i][0] for i in order)


def _turning(group: JointGroup) -> list[bool]:
    """Return which velocity coordinates may differ by whole turns and mean the same pose."""
    flags: list[bool] = []
    for joint in group.joints:
        match joint.type:
            case JointType.REVOLUTE | JointType.CONTINUOUS:
                flags.append(True)
            case JointType.PLANAR:
                flags += [False, False, True]
            case _:
                flags += [False] * len(joint.velocity_names)
    return flags
