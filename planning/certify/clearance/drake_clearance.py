"""Clearance proof by branch and bound with Drake's distances (adaptive bisection of the motion).

The distance of two shapes at an instant, minus their largest approach until either end of a segment
(`motion_bounds`), is a lower bound on their distance on the segment (the adaptive collision
checking of Schwarzer, Saha, Latombe, 2005). Where the bound is above the margin the segment is
proven for that pair; the remaining pairs are bounded again on both halves. The segment with the
smallest bound is always next, so that a collision is found early. Afterwards the segments that may
contain a smaller distance than the smallest measured one are halved until that one is known to a
tolerance.
"""

from heapq import heapify, heappop, heappush

import numpy as np

from planning.certify.clearance.clearance_result import (
    MARGIN_SLACK,
    ClearanceResult,
    Node,
    UnprovenPair,
    WitnessPoint,
)
from planning.certify.clearance.closest_approaches import ClosestApproaches
from planning.certify.clearance.pair_distances import Indices, Measured, PairDistances
from planning.certify.intervals.joint_deviation import Segment, Segments
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.report.certificate import Check
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Rounding error of bounds is less than this [m].
_ROUNDING = 1e-9
# Shortest segment [s] and largest number of segments; beyond these the proof fails as unproven.
_SHORTEST = 1e-7
_MOST_SEGMENTS = 20_000
# Segments on which shapes move more than this are halved without a distance query: too many pairs
# would be near [m].
_WIDE = 0.25
# Resolution of the smallest distance [m], the larger of these, and the number of segments for it.
_RESOLUTION = 1e-3
_RELATIVE_RESOLUTION = 0.01
_TIGHTENING_SEGMENTS = 400
# Number of instants sampled for the worst collision of a refused motion.
_INSTANTS = 33
_HORIZONS = (0.05, 0.2, 1.0, 5.0, 1e6)


class DrakeProof:
    """One clearance proof, in a Drake context of its own."""

    def __init__(
        self,
        model: DrakeModel,
        request: CertifyRequest,
        deadline: Deadline,
        most: int = _MOST_SEGMENTS,
    ) -> None:
        """Prepare a proof; it stops as unproven after `most` segments."""
        self._most = most
        self._request, self._deadline = request, deadline
        self._distances = PairDistances(model, request)
        self._segments = Segments(request.trajectory)
        self._pairs = self._distances.pairs
        margins = self._pairs.margins
        self._required = np.where(margins > 0, np.maximum(margins - MARGIN_SLACK, 0.0), margins)
        self._every = np.flatnonzero(self._pairs.is_moved)
        self._seen = ClosestApproaches(self._pairs)
        self._leaves: list[Node] = []
        self._number = 0

    def run(self) -> ClearanceResult:
        """Return the result of the proof, proven or not.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
        """
        fixed = self._fixed_violation()
        if fixed is not None:
            return self._of_pair(*fixed)
        if len(self._every) == 0:
            return self._verdict(np.inf)
        for time in (0.0, self._request.trajectory.duration):
            self._look(time)
        heap = [Node(-np.inf, 0, self._segments.whole, self._every)]
        while heap:
            node = heappop(heap)
            outcome = self._judge(node)
            if isinstance(outcome, UnprovenPair):
                return self._refusal(outcome)
            for child in outcome:
                heappush(heap, child)
        return self._verdict(self._tighten())

    def _judge(self, node: Node) -> list[Node] | UnprovenPair:
        """Decide the pairs on a segment as far as possible; return nodes for the undecided ones."""
        approaches = self._enter(node.segment, node.open)
        widest = float(approaches.max())
        if not np.isfinite(widest):
            return UnprovenPair(
                int(node.open[np.argmax(approaches)]), np.inf, np.inf, node.segment.time
            )
        exhausted = _is_short(node.segment) or self._number > self._most
        if widest > _WIDE and not exhausted:
            return self._split(node, node.open, node.floor, node.proven)
        required = self._required[node.open]
        wanted = approaches + required + 2 * _ROUNDING
        measured = self._measure(node.open, wanted, node.segment.time)
        if (measured.distances <= required).any():
            worst = int(np.argmin(measured.distances - required))
            return self._refuse(measured, worst, 0.0, node.segment.time)
        lower = measured.lower - approaches
        spare = lower - required
        decided = spare > _ROUNDING
        proven = min(node.proven, float(lower[decided].min(initial=np.inf)))
        if decided.all():
            self._leaves.append(Node(proven, node.number, node.segment, node.open, proven))
            return []
        if exhausted:
            worst = int(np.argmin(spare))
            uncertainty = float(measured.distances[worst] - lower[worst])
            return self._refuse(measured, worst, uncertainty, node.segment.time)
        return self._split(node, node.open[~decided], float(spare.min()), proven)

    def _refuse(self, measured: Measured, i: int, uncertainty: float, time: float) -> UnprovenPair:
        return UnprovenPair(int(measured.pairs[i]), float(measured.distances[i]), uncertainty, time)

    def _split(self, node: Node, rest: Indices, floor: float, proven: float) -> list[Node]:
        children: list[Node] = []
        for half in self._segments.halves(node.segment):
            self._number += 1
            children.append(Node(floor, self._number, half, rest, proven))
        return children

    def _tighten(self) -> float:
        """Halve segments that may contain a smaller distance; return a bound on the smallest."""
        leaves = self._leaves
        heapify(leaves)
        last = self._seen.count + _TIGHTENING_SEGMENTS
        while self._seen.count < last:
            distance = self._seen.nearest.distance
            target = distance - max(_RESOLUTION, _RELATIVE_RESOLUTION * distance)
            segment = leaves[0].segment
            if leaves[0].floor >= target or _is_short(segment):
                break
            node = heappop(leaves)
            for child in self._split(node, self._every, node.floor, node.proven):
                approaches = self._enter(child.segment, child.open)
                wanted = approaches + (target + 2 * _ROUNDING)
                measured = self._measure(child.open, wanted, child.segment.time)
                child.floor = max(child.floor, float((measured.lower - approaches).min()))
                heappush(leaves, child)
        return leaves[0].floor

    def _enter(self, segment: Segment, pairs: Indices) -> Array:
        """Put the group at a segment's centre; return the largest approach of each pair [m]."""
        if self._number % 8 == 0:
            self._deadline.check("certify")
        self._distances.go_to(segment.center)
        return self._distances.approaches(segment, pairs)

    def _measure(self, pairs: Indices, wanted: Array, time: float) -> Measured:
        measured = self._distances.measure(pairs, wanted)
        self._seen.see(pairs, measured.distances, time)
        return measured

    def _sample(self, within: float, time: float) -> int:
        """Measure all near pairs at an instant; return their number."""
        self._distances.go_to(self._request.trajectory.positions(np.array([time]))[0])
        pairs, distances = self._distances.sample(within)
        self._seen.see(pairs, distances, time)
        return len(pairs)

    def _look(self, time: float) -> None:
        """Measure the nearest pair at an instant, at any distance."""
        for horizon in _HORIZONS:
            if self._sample(horizon, time):
                return

    def _fixed_violation(self) -> tuple[int, float, float, float] | None:
        """Return pair, distance, uncertainty and time of a violation among static pairs, or None.

        Static pairs are measured once. Contact between them is no violation if the margin is zero.
        """
        fixed = np.flatnonzero(~self._pairs.is_moved)
        required = self._pairs.margins[fixed] - MARGIN_SLACK
        measured = self._distances.measure(fixed, required)
        spare = measured.lower - required
        if not (spare < 0).any():
            return None
        worst = int(np.argmin(spare))
        distance, lower = float(measured.distances[worst]), float(measured.lower[worst])
        return int(fixed[worst]), distance, max(distance - lower, 0.0), 0.0

    def _verdict(self, floor: float) -> ClearanceResult:
        nearest = self._seen.nearest.distance
        gap = max(0.0, nearest - floor) if np.isfinite(nearest) else 0.0
        return self._result(*self._tightest(gap, passed=True))

    def _refusal(self, refused: UnprovenPair) -> ClearanceResult:
        """Return the result of a failed proof; for a collision, with the worst one at samples."""
        if refused.distance <= self._required[refused.pair]:
            within = max(self._request.margins.largest, 0.0)
            for time in np.linspace(0.0, self._request.trajectory.duration, _INSTANTS):
                self._sample(within, float(time))
            return self._result(*self._tightest(0.0, passed=False))
        return self._of_pair(refused.pair, refused.distance, refused.uncertainty, refused.time)

    def _of_pair(
        self, pair: int, distance: float, uncertainty: float, time: float
    ) -> ClearanceResult:
        """Return the result of a proof that failed at one pair."""
        check = Check(
            name="clearance",
            value=distance,
            bound=float(self._pairs.margins[pair]),
            unit="m",
            resolution=uncertainty,
            passed=False,
            where="-".join(self._pairs.names[pair]),
            time=time,
        )
        bodies = self._pairs.names[pair]
        return self._result(check, WitnessPoint(self._pairs.ids[pair], bodies, distance, time))

    def _tightest(self, resolution: float, *, passed: bool) -> tuple[Check, WitnessPoint]:
        """Return the check and the witness point of the pair with the smallest reserve."""
        seen = self._seen.tightest
        check = Check(
            name="clearance",
            value=seen.distance,
            bound=seen.margin,
            unit="m",
            resolution=resolution,
            passed=passed,
            where=seen.where,
            time=seen.time,
        )
        return check, seen.spot

    def _result(self, check: Check, checked: WitnessPoint) -> ClearanceResult:
        nearest = self._seen.nearest.spot
        return ClearanceResult(check, nearest, checked, self._number + 1, self._seen.count)


def _is_short(segment: Segment) -> bool:
    return segment.is_part and segment.end - segment.begin < _SHORTEST
