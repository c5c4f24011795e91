"""Branch and bound: the maximum of a quantity along a whole trajectory.

A quantity is measured at a segment's centre; the largest joint motion within the segment bounds its
growth anywhere in it. Segments whose upper bound does not exceed the limit are proven, the others
are halved, the one with the largest upper bound first.
"""

from dataclasses import dataclass, field
from heapq import heapify, heappop, heappush
from typing import Protocol, runtime_checkable

import numpy as np

from planning.certify.intervals.joint_deviation import Segment, Segments
from planning.certify.request import CertifyRequest
from planning.domain.request.deadline import Deadline

# Tolerance above a bound: a start that lies on it would be refused for rounding.
SLACK = 1e-6
# Shortest segment [s] and largest number of segments; beyond these the search fails as unproven.
_SHORTEST = 1e-6
_MOST_SEGMENTS = 20_000
# Resolution of the largest value, relative to the bound or absolute, and the number of additional
# segments for it.
_RESOLUTION, _LEAST = 0.02, 1e-4
_TIGHTENING = 100


@dataclass(frozen=True)
class QuantityBound:
    """A quantity on a segment: its value at the centre, and an upper bound.

    Attributes:
        value: Value at the centre.
        top: Upper bound on all of the segment.
        where: Name of the worst object (a pair, a joint) at the centre.
    """

    value: float
    top: float
    where: str = ""


@runtime_checkable
class Quantity(Protocol):
    """A quantity that must not exceed a bound."""

    def look(self, segment: Segment) -> QuantityBound:
        """Return the value at the centre of a segment, and a bound on all of it."""
        ...


@dataclass(frozen=True)
class BoundResult:
    """Result of branch and bound: the largest value of a quantity.

    Attributes:
        value: Largest measured value.
        top: Upper bound on the whole trajectory, unproven parts included; infinite if unknown.
        passed: Whether the quantity is proven to keep its bound.
        where: Name of the worst object.
        time: Instant of the largest value [s].
    """

    value: float
    top: float
    passed: bool
    where: str
    time: float


@dataclass(order=True)
class _Node:
    """A segment of the search, ordered by its negated upper bound."""

    rank: float
    number: int
    segment: Segment = field(compare=False)


def bounded(
    quantity: Quantity, bound: float, request: CertifyRequest, deadline: Deadline
) -> BoundResult:
    """Prove, or fail to prove, that a quantity keeps its bound on the whole trajectory.

    Args:
        quantity: The quantity, in the unit of the bound.
        bound: Upper limit, with the tolerance `SLACK`.
        request: The request with the trajectory.
        deadline: Time limit.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    return _Bisection(quantity, bound, request, deadline).run()


@dataclass(frozen=True)
class BoundTolerance:
    """Tolerance of a largest value, and the effort for it.

    Attributes:
        share: Relative tolerance.
        least: Absolute tolerance, in the quantity's unit; the larger of both counts.
        looks: Largest number of segments.
    """

    share: float
    least: float
    looks: int


def bound_maximum(
    quantity: Quantity, fineness: BoundTolerance, request: CertifyRequest, deadline: Deadline
) -> BoundResult:
    """Return the largest value of a quantity without a limit; `top` is always an upper bound.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    return _Bisection(quantity, np.inf, request, deadline).highest(fineness)


class _Bisection:
    """One branch-and-bound search over segments."""

    def __init__(
        self, quantity: Quantity, bound: float, request: CertifyRequest, deadline: Deadline
    ) -> None:
        self._quantity, self._bound = quantity, bound
        self._segments, self._deadline = Segments(request.trajectory), deadline
        self._worst = QuantityBound(-np.inf, -np.inf)
        self._time = 0.0
        self._count = 0

    def run(self) -> BoundResult:
        heap = [self._node(self._segments.whole)]
        leaves: list[_Node] = []
        while heap:
            node = heappop(heap)
            if self._worst.value > self._bound + SLACK:
                # No remaining segment has a larger bound, and the leaves keep theirs.
                return self._finding(-node.rank, passed=False)
            if -node.rank <= self._bound + SLACK:
                leaves.append(node)
            elif self._is_hopeless(node.segment):
                return self._finding(-node.rank, passed=False)
            else:
                for half in self._segments.halves(node.segment):
                    heappush(heap, self._node(half))
        fineness = BoundTolerance(0.0, max(_RESOLUTION * abs(self._bound), _LEAST), _TIGHTENING)
        return self._finding(self._tightened(leaves, fineness), passed=True)

    def highest(self, fineness: BoundTolerance) -> BoundResult:
        whole = self._node(self._segments.whole)
        return self._finding(self._tightened([whole], fineness), passed=True)

    def _tightened(self, leaves: list[_Node], fineness: BoundTolerance) -> float:
        """Halve segments that may contain a larger value; return an upper bound on all."""
        heapify(leaves)
        last = self._count + fineness.looks
        while self._count < last:
            seen = self._worst.value
            fine = max(fineness.least, fineness.share * abs(seen)) if np.isfinite(seen) else 0.0
            if not -leaves[0].rank > seen + fine:
                break
            node = heappop(leaves)
            for half in self._segments.halves(node.segment):
                child = self._node(half)
                # A bound proven for a segment holds for its halves.
                child.rank = max(child.rank, node.rank)
                heappush(leaves, child)
        return -leaves[0].rank

    def _node(self, segment: Segment) -> _Node:
        if self._count % 16 == 0:
            self._deadline.check("certify")
        self._count += 1
        sight = self._quantity.look(segment)
        if sight.value > self._worst.value:
            self._worst, self._time = sight, segment.time
        return _Node(-sight.top, self._count, segment)

    def _is_hopeless(self, segment: Segment) -> bool:
        is_short = segment.is_part and segment.end - segment.begin < _SHORTEST
        return is_short or self._count > _MOST_SEGMENTS

    def _finding(self, top: float, *, passed: bool) -> BoundResult:
        worst = self._worst
        return BoundResult(worst.value, max(top, worst.value), passed, worst.where, self._time)
