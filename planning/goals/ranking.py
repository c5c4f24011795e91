"""Ranking of IK solutions: removal of duplicates, equivalents by full turns, nearest first."""

import numpy as np
from jaxtyping import Bool, Float64, Int64

from planning.domain.arrays import Array, Flags, Indices
from planning.domain.robot.joints import JointGroup, JointLimits, JointType
from planning.domain.robot.manifold import Manifold
from planning.goals.joint_metric import JointMetric

# Two configurations nearer than this in every joint are duplicates [rad or m].
SAME = 1e-3
_MAX_EQUIVALENTS = 4096


class UniqueSolutions:
    """Set of solutions without duplicates (modulo full turns) among those of the same target.

    Attributes:
        rows: Configurations, shape (n, nq).
        targets: Index of the target that each reaches, shape (n,).
    """

    def __init__(self, group: JointGroup, manifold: Manifold) -> None:
        """Create an empty set."""
        self._manifold = manifold
        self._turns = np.array(_turning(group), dtype=bool)
        self._keyed = np.array(
            [
                not (joint.type is JointType.FLOATING and i < 4)
                for joint in group.joints
                for i in range(joint.num_positions)
            ],
            dtype=bool,
        )
        self._phases = np.sqrt(2.0 + np.arange(self._keyed.sum()))
        self.rows: Array = np.zeros((0, group.num_positions))
        self.targets: Indices = np.zeros(0, dtype=np.int64)

    def __len__(self) -> int:
        """Return the number of solutions."""
        return len(self.rows)

    def add(self, rows: Float64[np.ndarray, "n nq"], targets: Int64[np.ndarray, " n"]) -> None:
        """Add solutions that `are_new`; this is not checked again."""
        self.rows = np.concatenate([self.rows, rows])
        self.targets = np.concatenate([self.targets, targets])

    def are_new(
        self, rows: Float64[np.ndarray, "n nq"], targets: Int64[np.ndarray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        """Return whether each row differs from all in the set and from the rows before it."""
        every = np.concatenate([self.rows, rows])
        labels = self._alike(every, np.concatenate([self.targets, targets]))
        first = np.unique(labels, return_index=True)[1]
        kept = np.zeros(len(every), dtype=bool)
        kept[first] = True
        return kept[len(self.rows) :]

    def contains(
        self, rows: Float64[np.ndarray, "n nq"], targets: Int64[np.ndarray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        """Return whether each row is a duplicate of one in the set."""
        every = np.concatenate([self.rows, rows])
        labels = self._alike(every, np.concatenate([self.targets, targets]))
        return np.isin(labels[len(self.rows) :], labels[: len(self.rows)])

    def _alike(self, rows: Array, targets: Indices) -> Indices:
        """Return cluster labels: duplicates, or rows linked by a chain of them, share a number.

        Sums of cosines and of sines change by at most the sum of the changes of their angles, so
        only rows whose sums are close can be duplicates.
        """
        angles, close = rows[:, self._keyed] + self._phases, SAME * len(self._phases) + 1e-9
        keys, others = np.cos(angles).sum(axis=1), np.sin(angles).sum(axis=1)
        order = np.argsort(keys, kind="stable")
        keys, others, labels = keys[order], others[order], np.arange(len(keys))
        for step in range(1, len(keys)):
            near = keys[step:] - keys[:-step] <= close
            a = np.flatnonzero(near & (labels[step:] != labels[:-step]))
            # Any duplicates farther apart in this order share a label already.
            if not len(a):
                break
            a = a[np.abs(others[a + step] - others[a]) <= close]
            if not len(a):
                continue
            same = self._are_same(rows[order[a]], rows[order[a + step]])
            same &= targets[order[a]] == targets[order[a + step]]
            for i in a[same]:
                labels[labels == labels[i + step]] = labels[i]
        named = np.empty_like(labels)
        named[order] = labels
        return named

    def _are_same(self, a: Array, b: Array) -> Flags:
        delta = self._manifold.minus(a, b)
        delta[:, self._turns] = np.remainder(delta[:, self._turns] + np.pi, 2 * np.pi) - np.pi
        return np.abs(delta).max(axis=1, initial=0.0) <= SAME


def equivalents(
    group: JointGroup, limits: JointLimits, rows: Float64[np.ndarray, "m nq"]
) -> tuple[Float64[np.ndarray, "n nq"], Int64[np.ndarray, " n"]]:
    """Return each row with full turns added to its revolute joints in every way within limits.

    Continuous joints get no turns: a full turn of theirs is the same point of the manifold. Nor do
    leaders of mimic joints in `group.winding`: their followers are elsewhere after a full turn.

    Returns:
        The rows, all equivalents of one given row in sequence, and the index of the given row of
        each.
    """
    turning = np.array(
        [
            joint.type is JointType.REVOLUTE and joint.name not in group.winding
            for joint in group.joints
            for _ in joint.position_names
        ],
        dtype=bool,
    )
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
    metric: JointMetric,
    start: Float64[np.ndarray, " nq"],
    rows: Float64[np.ndarray, "n nq"],
    targets: Int64[np.ndarray, " n"],
    count: int,
) -> tuple[Array, tuple[int, ...]]:
    """Return the `count` rows nearest to the start and their target indices."""
    distances = metric.distance(rows, start)
    order = np.argsort(distances, kind="stable")[:count]
    return rows[order], tuple(int(i) for i in targets[order])


def _turning(group: JointGroup) -> list[bool]:
    """Return which velocity coordinates are angles that give the same pose after a full turn."""
    flags: list[bool] = []
    for joint in group.joints:
        match joint.type:
            case JointType.REVOLUTE | JointType.CONTINUOUS:
                flags.append(joint.name not in group.winding)
            case JointType.PLANAR:
                flags += [False, False, True]
            case _:
                flags += [False] * joint.num_velocities
    return flags
