"""A bound on a quantity along a whole trajectory, by conservative bisection.

A quantity is measured at a segment's centre; what the joints can move within the segment bounds how
much larger it can be anywhere in it. Segments on which that does not exceed the bound are proven,
the others are halved, the most suspicious first.
"""

from dataclasses import dataclass, field
from heapq import heapify, heappop, heappush
from typing import Protocol, runtime_checkable

import numpy as np

from planning.certify.intervals.joint_deviation import Segment, Segments
from planning.certify.request import CertifyRequest
from planning.domain.request.deadline import Deadline

# More than a bound by this is forgiven: a start that lies on it would be refused for rounding.
SLACK = 1e-6
# Segments shorter than this, or more of them, are given up as unproven [s].
_SHORTEST = 1e-6
_MOST_SEGMENTS = 20_000
# How well the largest value is to be known, as a share of the bound or at least, and what it may
# cost in segments.
_RESOLUTION, _LEAST = 0.02, 1e-4
_TIGHTENING = 100


@dataclass(frozen=True)
class QuantityBound:
    """A quantity at the centre of a segment.

    Attributes:
        value: As measured.
        top: At most so much anywhere in the segment.
        where: What is worst there.
    """

    value: float
    top: float
    where: str = ""


@runtime_checkable
class Quantity(Protocol):
    """Something that shall not exceed a bound."""

    def look(self, segment: Segment) -> QuantityBound:
        """Measure at the centre of a segment, and bound on all of it."""
        ...


@dataclass(frozen=True)
class BoundResult:
    """What is known of a quantity.

    Attributes:
        value: The largest that was measured.
        top: At most so much anywhere, also of what is not proven; infinite if that is not known.
        passed: Whether it is proven to keep its bound.
        where: What was worst.
        time: When [s].
    """

    value: float
    top: float
    passed: bool
    where: str
    time: float


@dataclass(order=True)
class _Node:
    rank: float
    number: int
    segment: Segment = field(compare=False)


def bounded(
    quantity: Quantity, bound: float, request: CertifyRequest, deadline: Deadline
) -> BoundResult:
    """Prove, or fail to prove, that a quantity keeps its bound throughout.

    Args:
        quantity: Measured in the unit of the bound.
        bound: May be passed by `SLACK`.
        request: Has the trajectory.
        deadline: When to stop.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The end was asked for.
    """
    return _Bisection(quantity, bound, request, deadline).run()


@dataclass(frozen=True)
class BoundTolerance:
    """How well a largest value is to be known, and what that may cost.

    Attributes:
        share: Of the value, or
        least: of its unit, whichever is larger.
        looks: Segments at most.
    """

    share: float
    least: float
    looks: int


def bound_maximum(
    quantity: Quantity, fineness: BoundTolerance, request: CertifyRequest, deadline: Deadline
) -> BoundResult:
    """Return how large a quantity becomes, whatever that is; `top` is a bound on it always.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The end was asked for.
    """
    return _Bisection(quantity, np.inf, request, deadline).highest(fineness)


class _Bisection:
    """One proof."""

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
                # No segment that is left has a larger bound, and the leaves keep theirs.
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
        """Halve the segments that may hide a larger value than was seen; return a bound on all."""
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
                # What was proven of the whole is true of its halves.
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
