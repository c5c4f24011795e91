"""smallest_delays(): the first delays, in lexicographic order, that keep to allowed differences.

For each pair of motions the allowed differences of their beginnings are some intervals. With one
interval chosen for each pair, the constraints are those of a simple temporal network, whose
earliest solution is the smallest in every delay at once: the longest paths from time 0 (Dechter,
Meiri & Pearl, "Temporal constraint networks", 1991). The choices are searched depth first, and left
where the earliest solution so far comes later than the best one known.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from planning.domain.request.deadline import Deadline

type Interval = tuple[float, float]
type Pair = tuple[int, int]

# Delays nearer than this are equal [s].
_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Delays:
    """Delays of some motions, and for which motion each waits.

    Attributes:
        delays: When each begins [s].
        waits_for: For each, the motion that makes it begin no earlier; None if it does not wait.
    """

    delays: tuple[float, ...]
    waits_for: tuple[int | None, ...]


def smallest_delays(
    count: int, allowed: Mapping[Pair, Sequence[Interval]], deadline: Deadline
) -> Delays | None:
    """Return the lexicographically smallest delays, none negative; None if there are none.

    Args:
        count: Number of motions.
        allowed: For pairs (i, j) with i < j, the closed intervals of delay_j - delay_i.
        deadline: Time limit.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    search = _Search(count, allowed, deadline)
    search.run({}, sorted(allowed, key=lambda pair: (max(pair), min(pair))))
    return search.best


class _Search:
    def __init__(
        self, count: int, allowed: Mapping[Pair, Sequence[Interval]], deadline: Deadline
    ) -> None:
        self._count, self._allowed, self._deadline = count, allowed, deadline
        self.best: Delays | None = None

    def run(self, chosen: dict[Pair, Interval], pairs: list[Pair]) -> None:
        """Try every interval of the remaining pairs, those near no delay first."""
        self._deadline.check("schedule")
        earliest = _earliest(self._count, chosen)
        if earliest is None or (self.best and not _is_before(earliest, self.best)):
            return
        if not pairs:
            self.best = earliest
            return
        pair, *others = pairs
        for interval in sorted(self._allowed[pair], key=_distance_from_zero):
            self.run({**chosen, pair: interval}, others)


def _is_before(one: Delays, other: Delays) -> bool:
    """Return whether delays come before others in lexicographic order."""
    for a, b in zip(one.delays, other.delays, strict=True):
        if abs(a - b) > _TOLERANCE:
            return a < b
    return False


def _distance_from_zero(interval: Interval) -> float:
    low, high = interval
    return max(low, -high, 0.0)


def _earliest(count: int, chosen: Mapping[Pair, Interval]) -> Delays | None:
    """Return the earliest delays under one interval for each pair; None if there are none."""
    edges = [
        edge
        for (i, j), (low, high) in chosen.items()
        for edge in ((i, j, low), (j, i, -high))
        if np.isfinite(edge[2])
    ]
    delays = [0.0] * count
    waits_for: list[int | None] = [None] * count
    for _ in range(count + 1):
        is_stable = True
        for before, after, gap in edges:
            if delays[before] + gap > delays[after] + _TOLERANCE:
                delays[after], waits_for[after] = delays[before] + gap, before
                is_stable = False
        if is_stable:
            return Delays(tuple(delays), tuple(waits_for))
    return None
