"""Which configurations are distinct, which whole turns they have, and which come first."""

from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int64

from planning.domain.joints import JointGroup, JointLimits, JointType
from planning.domain.manifold import Manifold

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.int64]]

# Two configurations nearer than this in every joint are one and the same [rad or m].
SAME = 1e-3
_MAX_EQUIVALENTS = 4096


class Distinct:
    """Solutions that differ, whole turns aside, from all others of the same target."""

    def __init__(self, group: JointGroup, manifold: Manifold) -> None:
        """Begin with none."""
        self._manifold = manifold
        self._turns = np.array(_turning(group), dtype=bool)
        self._keyed = np.array(
            [
                not (joint.type is JointType.FLOATING and i < 4)
                for joint in group.joints
                for i in range(len(joint.position_names))
            ],
            dtype=bool,
        )
        self._phases = np.sqrt(2.0 + np.arange(self._keyed.sum()))
        self.rows: Array = np.zeros((0, group.num_positions))
        self.targets: Indices = np.zeros(0, dtype=np.int64)

    def __len__(self) -> int:
        """How many there are."""
        return len(self.rows)

    def add(self, rows: Float64[np.ndarray, "n nq"], targets: Int64[np.ndarray, " n"]) -> None:
        """Add solutions that are known to be new."""
        self.rows = np.concatenate([self.rows, rows])
        self.targets = np.concatenate([self.targets, targets])

    def are_new(
        self, rows: Float64[np.ndarray, "n nq"], targets: Int64[np.ndarray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        """Return whether each row differs from all here and from the new ones before it."""
        every, known = np.concatenate([self.rows, rows]), len(self.rows)
        of = np.concatenate([self.targets, targets])
        later, earlier = self._alike(every, of)
        kept = np.ones(len(every), dtype=bool)
        for i, j in zip(later, earlier, strict=True):
            if i >= known and kept[j]:
                kept[i] = False
        return kept[known:]

    def _alike(self, rows: Array, targets: Indices) -> tuple[Indices, Indices]:
        """Return the pairs (i, j < i) of rows that are the same, by rising i.

        A sum of cosines changes by at most the sum of the changes of its angles, so only rows whose
        sums are close need a closer look.
        """
        keys = np.cos(rows[:, self._keyed] + self._phases).sum(axis=1)
        a, b = _pairs_within(keys, SAME * len(self._phases) + 1e-9)
        i, j = np.maximum(a, b), np.minimum(a, b)
        delta = self._manifold.minus(rows[i], rows[j])
        delta[:, self._turns] = np.remainder(delta[:, self._turns] + np.pi, 2 * np.pi) - np.pi
        same = (np.abs(delta).max(axis=1, initial=0.0) <= SAME) & (targets[i] == targets[j])
        order = np.argsort(i[same], kind="stable")
        return i[same][order], j[same][order]


def equivalents(
    group: JointGroup, limits: JointLimits, rows: Float64[np.ndarray, "m nq"]
) -> tuple[Float64[np.ndarray, "n nq"], Int64[np.ndarray, " n"]]:
    """Return each row with whole turns added to its revolute joints in every way within limits.

    Continuous joints have none: a whole turn of theirs is the same point of the manifold.

    Returns:
        The rows, each followed by no other row's, and which of the given ones each is.
    """
    kinds = [joint.type for joint in group.joints for _ in joint.position_names]
    turning = np.array([kind is JointType.REVOLUTE for kind in kinds], dtype=bool)
    first, last = np.zeros(rows.shape), np.zeros(rows.shape)
    low, high = limits.lower[turning], limits.upper[turning]
    first[:, turning] = np.ceil((low - rows[:, turning]) / (2 * np.pi) - 1e-12)
    last[:, turning] = np.floor((high - rows[:, turning]) / (2 * np.pi) + 1e-12)
    choices = np.prod(np.maximum(last - first + 1, 1), axis=1)
    fixed = (last < first) | (choices > _MAX_EQUIVALENTS)[:, None]
    first[fixed] = last[fixed] = 0
    index = np.arange(len(rows))
    for k in np.flatnonzero((first != last).any(axis=0)):
        count = (last - first)[index, k].astype(int) + 1
        turn = np.concatenate([
            first[i, k] + np.arange(n) for i, n in zip(index, count, strict=True)
        ])
        rows, index = np.repeat(rows, count, axis=0), np.repeat(index, count)
        rows[:, k] += 2 * np.pi * turn
    return np.where(turning, np.clip(rows, limits.lower, limits.upper), rows), index


def nearest_first(
    manifold: Manifold,
    start: Float64[np.ndarray, " nq"],
    rows: Float64[np.ndarray, "n nq"],
    targets: Int64[np.ndarray, " n"],
    count: int,
) -> tuple[Array, tuple[int, ...]]:
    """Return the `count` rows nearest to the start and their target indices."""
    distances = manifold.distance(rows, start[None])
    order = np.argsort(distances, kind="stable")[:count]
    return rows[order], tuple(int(i) for i in targets[order])


def _pairs_within(keys: Array, distance: float) -> tuple[Indices, Indices]:
    """Return every pair of indices whose keys differ by at most `distance`, once."""
    order = np.argsort(keys, kind="stable")
    rising = keys[order]
    a: list[Indices] = [order[:0]]
    b: list[Indices] = [order[:0]]
    for step in range(1, len(keys)):
        near = np.flatnonzero(rising[step:] - rising[:-step] <= distance)
        if not len(near):
            break
        a.append(order[near])
        b.append(order[near + step])
    return np.concatenate(a), np.concatenate(b)


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
