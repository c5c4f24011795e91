"""Ranking of IK solutions: removal of duplicates, equivalents by full turns, nearest first."""

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64, Int64

from planning.domain.arrays import Array, Flags, Indices
from planning.domain.robot.joints import JointGroup, JointLimits, JointType
from planning.domain.robot.manifold import Manifold
from planning.goals.joint_metric import JointMetric
from planning.kernel.native import native

# Two configurations nearer than this in every joint are duplicates [rad or m].
DUPLICATE_TOLERANCE = 1e-3
_MAX_EQUIVALENTS = 4096
# No full turn fits into limits shorter than one by this, whatever the rounding [rad].
_LEAST_SHORT_OF_A_TURN = 1e-6
# Pairs that are compared at once.
_MAX_PAIRS = 20_000


class UniqueSolutions:
    """Set of solutions without duplicates (modulo full turns) among those of the same target.

    Attributes:
        rows: Configurations, shape (n, nq).
        targets: Index of the target that each reaches, shape (n,).
    """

    def __init__(self, group: JointGroup, manifold: Manifold) -> None:
        """Create an empty set."""
        self._manifold = manifold
        self._group = group
        self.rows: Array = np.zeros((0, group.num_positions))
        self.targets: Indices = np.zeros(0, dtype=np.int64)

    @cached_property
    def _is_periodic(self) -> Flags:
        return np.array(_periodic_coordinates(self._group), dtype=bool)

    @cached_property
    def _key_mask(self) -> Flags:
        """Which coordinates have an angle or a length: not those of quaternions."""
        flags = [
            not (joint.type is JointType.FLOATING and i < 4)
            for joint in self._group.joints
            for i in range(joint.num_positions)
        ]
        return np.array(flags, dtype=bool)

    @cached_property
    def _phases(self) -> Array:
        return np.sqrt(2.0 + np.arange(self._key_mask.sum()))

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
        if not len(rows):
            return np.zeros(0, dtype=bool)
        all_rows = np.concatenate([self.rows, rows])
        all_targets = np.concatenate([self.targets, targets])
        module = native()
        if module is not None and self._manifold.is_vector_space:
            is_first = module.first_of_clusters(
                all_rows, all_targets, self._is_periodic, DUPLICATE_TOLERANCE
            )
        else:
            is_first = self.are_first_in_numpy(all_rows, all_targets)
        return is_first[len(self.rows) :]

    def are_first_in_numpy(
        self, rows: Float64[np.ndarray, "n nq"], targets: Int64[np.ndarray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        """Return whether each row is the first of its duplicates; what the kernel is compared with.

        For any joints, where the kernel has those that neither wrap nor float.
        """
        labels = self._cluster_labels(rows, targets)
        first = np.unique(labels, return_index=True)[1]
        is_first = np.zeros(len(rows), dtype=bool)
        is_first[first] = True
        return is_first

    def contains(
        self, rows: Float64[np.ndarray, "n nq"], targets: Int64[np.ndarray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        """Return whether each row is a duplicate of one in the set."""
        all_rows = np.concatenate([self.rows, rows])
        labels = self._cluster_labels(all_rows, np.concatenate([self.targets, targets]))
        return np.isin(labels[len(self.rows) :], labels[: len(self.rows)])

    def _cluster_labels(self, rows: Array, targets: Indices) -> Indices:
        """Return cluster labels: duplicates, or rows linked by a chain of them, share a number.

        Sums of cosines and of sines change by at most the sum of the changes of their angles, so
        only rows whose sums are close can be duplicates.
        """
        angles = rows[:, self._key_mask] + self._phases
        key_tolerance = DUPLICATE_TOLERANCE * len(self._phases) + 1e-9
        cosine_sums, sine_sums = np.cos(angles).sum(axis=1), np.sin(angles).sum(axis=1)
        order = np.argsort(cosine_sums, kind="stable")
        cosine_sums, sine_sums = cosine_sums[order], sine_sums[order]
        rows, targets = rows[order], targets[order]

        def are_linked(a: Indices, b: Indices) -> Flags:
            return (targets[a] == targets[b]) & self._are_duplicates(rows[a], rows[b])

        neighbours = np.arange(1, len(rows))
        labels = np.append(0, np.cumsum(~are_linked(neighbours - 1, neighbours)))[: len(rows)]
        for firsts, seconds in _near_pairs(cosine_sums, key_tolerance):
            is_near = labels[firsts] != labels[seconds]
            is_near &= np.abs(sine_sums[seconds] - sine_sums[firsts]) <= key_tolerance
            a, b = firsts[is_near], seconds[is_near]
            is_linked = are_linked(a, b)
            for i, k in zip(a[is_linked], b[is_linked], strict=True):
                labels[labels == labels[k]] = labels[i]
        labels_by_row = np.empty_like(labels)
        labels_by_row[order] = labels
        return labels_by_row

    def _are_duplicates(self, a: Array, b: Array) -> Flags:
        delta = self._manifold.minus(a, b)
        delta[:, self._is_periodic] = (
            np.remainder(delta[:, self._is_periodic] + np.pi, 2 * np.pi) - np.pi
        )
        return np.abs(delta).max(axis=1, initial=0.0) <= DUPLICATE_TOLERANCE


def _near_pairs(
    ascending: Float64[np.ndarray, " n"], tolerance: float
) -> Iterator[tuple[Indices, Indices]]:
    """Yield index pairs i < k of numbers at most `tolerance` apart, some thousands at once."""
    ends = np.searchsorted(ascending, ascending + tolerance, side="right")
    counts = np.maximum(ends - np.arange(len(ascending)) - 1, 0)
    batches = np.cumsum(counts) // _MAX_PAIRS
    for first in np.split(np.arange(len(ascending)), np.flatnonzero(np.diff(batches)) + 1):
        own = counts[first]
        a = np.repeat(first, own)
        yield a, a + 1 + np.arange(len(a)) - np.repeat(np.cumsum(own) - own, own)


def full_turn_equivalents(
    group: JointGroup,
    limits: JointLimits,
    rows: Float64[np.ndarray, "m nq"],
    idle: Bool[np.ndarray, " nq"] | None = None,
) -> tuple[Float64[np.ndarray, "n nq"], Int64[np.ndarray, " n"]]:
    """Return each row with full turns added to its revolute joints in every way within limits.

    Continuous joints get no turns: a full turn of theirs is the same point of the manifold. Nor do
    leaders of mimic joints in `group.winding`: their followers are elsewhere after a full turn.

    Args:
        group: The group.
        limits: Its limits.
        rows: Configurations within them.
        idle: Coordinates that get no turns, as they do not move the tool; None for none.

    Returns:
        The rows, all equivalents of one given row in sequence, and the index of the given row of
        each.
    """
    is_revolute = np.array(
        [
            joint.type is JointType.REVOLUTE and joint.name not in group.winding
            for joint in group.joints
            for _ in joint.position_names
        ],
        dtype=bool,
    )
    if idle is not None:
        is_revolute &= ~idle
    low, high = limits.lower[is_revolute], limits.upper[is_revolute]
    if (high - low < 2 * np.pi - _LEAST_SHORT_OF_A_TURN).all():
        clipped = np.minimum(np.maximum(rows, limits.lower), limits.upper)
        return np.where(is_revolute, clipped, rows), np.arange(len(rows))
    min_turns, max_turns = np.zeros(rows.shape), np.zeros(rows.shape)
    min_turns[:, is_revolute] = np.ceil((low - rows[:, is_revolute]) / (2 * np.pi) - 1e-12)
    max_turns[:, is_revolute] = np.floor((high - rows[:, is_revolute]) / (2 * np.pi) + 1e-12)
    num_equivalents = np.prod(np.maximum(max_turns - min_turns + 1, 1), axis=1)
    fixed = (max_turns < min_turns) | (num_equivalents > _MAX_EQUIVALENTS)[:, None]
    min_turns[fixed] = max_turns[fixed] = 0
    index = np.arange(len(rows))
    for k in np.flatnonzero((min_turns != max_turns).any(axis=0)):
        count = (max_turns - min_turns)[index, k].astype(int) + 1
        turns = np.concatenate([
            min_turns[i, k] + np.arange(n) for i, n in zip(index, count, strict=True)
        ])
        rows, index = np.repeat(rows, count, axis=0), np.repeat(index, count)
        rows[:, k] += 2 * np.pi * turns
    return np.where(is_revolute, np.clip(rows, limits.lower, limits.upper), rows), index


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
    return rows[order], tuple(targets[order].tolist())


def _periodic_coordinates(group: JointGroup) -> list[bool]:
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
