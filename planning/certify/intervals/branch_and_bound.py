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
BOUND_TOLERANCE = 1e-6
# Shortest segment [s] and largest number of segments; beyond these the search fails as unproven.
_MIN_SEGMENT_DURATION = 1e-6
_MAX_SEGMENTS = 20_000
# Resolution of the largest value, relative to the bound or absolute, and the number of additional
# segments for it.
_RELATIVE_RESOLUTION, _ABSOLUTE_RESOLUTION = 0.02, 1e-4
_REFINEMENT_SEGMENTS = 100


@dataclass(frozen=True)
class QuantityBound:
    """A quantity on a segment: its value at the centre, and an upper bound.

    Attributes:
        value: Value at the centre.
        upper_bound: Upper bound on all of the segment.
        where: Name of the worst object (a pair, a joint) at the centre.
    """

    value: float
    upper_bound: float
    where: str = ""


@runtime_checkable
class Quantity(Protocol):
    """A quantity that must not exceed a bound."""

    def evaluate(self, segment: Segment) -> QuantityBound:
        """Return the value at the centre of a segment, and a bound on all of it."""
        ...


@dataclass(frozen=True)
class BoundResult:
    """Result of branch and bound: the largest value of a quantity.

    Attributes:
        value: Largest measured value.
        upper_bound: Upper bound on the whole trajectory, unproven parts included; infinite if
            unknown.
        passed: Whether the quantity is proven to keep its bound.
        where: Name of the worst object.
        time: Instant of the largest value [s].
    """

    value: float
    upper_bound: float
    passed: bool
    where: str
    time: float


@dataclass(order=True)
class _Node:
    """A segment of the search, ordered by its negated upper bound."""

    rank: float
    number: int
    segment: Segment = field(compare=False)


def prove_bound(
    quantity: Quantity, bound: float, request: CertifyRequest, deadline: Deadline
) -> BoundResult:
    """Prove, or fail to prove, that a quantity keeps its bound on the whole trajectory.

    Args:
        quantity: The quantity, in the unit of the bound.
        bound: Upper limit, with the tolerance `BOUND_TOLERANCE`.
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
        relative: Relative tolerance.
        absolute: Absolute tolerance, in the quantity's unit; the larger of both counts.
        max_segments: Largest number of segments.
    """

    relative: float
    absolute: float
    max_segments: int


def bound_maximum(
    quantity: Quantity, tolerance: BoundTolerance, request: CertifyRequest, deadline: Deadline
) -> BoundResult:
    """Return the largest value of a quantity without a limit; `upper_bound` always holds.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    return _Bisection(quantity, np.inf, request, deadline).bound_maximum(tolerance)


class _Bisection:
    """One branch-and-bound search over segments."""

    def __init__(
        self, quantity: Quantity, bound: float, request: CertifyRequest, deadline: Deadline
    ) -> None:
        self._quantity, self._bound = quantity, bound
        self._segments, self._deadline = Segments(request.trajectory), deadline
        self._largest = QuantityBound(-np.inf, -np.inf)
        self._time = 0.0
        self._count = 0

    def run(self) -> BoundResult:
        heap = [self._node(self._segments.whole)]
        leaves: list[_Node] = []
        while heap:
            node = heappop(heap)
            if self._largest.value > self._bound + BOUND_TOLERANCE:
                # No remaining segment has a larger bound, and the leaves keep theirs.
                return self._result(-node.rank, passed=False)
            if -node.rank <= self._bound + BOUND_TOLERANCE:
                leaves.append(node)
            elif self._is_exhausted(node.segment):
                return self._result(-node.rank, passed=False)
            else:
                for half in self._segments.halves(node.segment):
                    heappush(heap, self._node(half))
        tolerance = BoundTolerance(
            0.0,
            max(_RELATIVE_RESOLUTION * abs(self._bound), _ABSOLUTE_RESOLUTION),
            _REFINEMENT_SEGMENTS,
        )
        return self._result(self._refine_maximum(leaves, tolerance), passed=True)

    def bound_maximum(self, tolerance: BoundTolerance) -> BoundResult:
        whole = self._node(self._segments.whole)
        return self._result(self._refine_maximum([whole], tolerance), passed=True)

    def _refine_maximum(self, leaves: list[_Node], tolerance: BoundTolerance) -> float:
        """Halve segments that may contain a larger value; return an upper bound on all."""
        heapify(leaves)
        max_count = self._count + tolerance.max_segments
        while self._count < max_count:
            largest = self._largest.value
            max_gap = (
                max(tolerance.absolute, tolerance.relative * abs(largest))
                if np.isfinite(largest)
                else 0.0
            )
            if not -leaves[0].rank > largest + max_gap:
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
        bound = self._quantity.evaluate(segment)
        if bound.value > self._largest.value:
            self._largest, self._time = bound, segment.time
        return _Node(-bound.upper_bound, self._count, segment)

    def _is_exhausted(self, segment: Segment) -> bool:
        is_short = segment.is_within_piece and segment.end - segment.begin < _MIN_SEGMENT_DURATION
        return is_short or self._count > _MAX_SEGMENTS

    def _result(self, upper_bound: float, *, passed: bool) -> BoundResult:
        largest = self._largest
        return BoundResult(
            largest.value, max(upper_bound, largest.value), passed, largest.where, self._time
        )
