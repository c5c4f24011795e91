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
    MARGIN_TOLERANCE,
    ClearanceResult,
    Node,
    UnprovenPair,
    WitnessPoint,
)
from planning.certify.clearance.closest_approaches import ClosestApproaches
from planning.certify.clearance.pair_distances import MeasuredDistances, PairDistances
from planning.certify.intervals.joint_deviation import Segment, Segments
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array, Indices
from planning.domain.report.certificate import Check
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Rounding error of bounds is less than this [m].
_ROUNDING = 1e-9
# Shortest segment [s] and largest number of segments; beyond these the proof fails as unproven.
_MIN_SEGMENT_DURATION = 1e-7
_MAX_SEGMENTS = 20_000
# Segments on which shapes move more than this are halved without a distance query, as too many
# pairs would be near [m].
_MAX_APPROACH = 0.25
# Resolution of the smallest distance [m], the larger of these, and the number of segments for it.
_RESOLUTION = 1e-3
_RELATIVE_RESOLUTION = 0.01
_REFINEMENT_SEGMENTS = 400
# Number of instants sampled for the worst collision of a refused motion.
_NUM_INSTANTS = 33
# Distances within which the nearest pair is searched, one after another [m].
_HORIZONS = (0.05, 0.2, 1.0, 5.0, 1e6)


class DrakeProof:
    """One clearance proof, in a Drake context of its own."""

    def __init__(
        self,
        model: DrakeModel,
        request: CertifyRequest,
        deadline: Deadline,
        max_segments: int = _MAX_SEGMENTS,
    ) -> None:
        """Prepare a proof; it stops as unproven after `max_segments` segments."""
        self._max_segments = max_segments
        self._request, self._deadline = request, deadline
        self._distances = PairDistances(model, request)
        self._segments = Segments(request.trajectory)
        self._pairs = self._distances.pairs
        margins = self._pairs.margins
        self._required = np.where(margins > 0, np.maximum(margins - MARGIN_TOLERANCE, 0.0), margins)
        self._moving_pairs = np.flatnonzero(self._pairs.is_moved)
        self._closest = ClosestApproaches(self._pairs)
        self._leaves: list[Node] = []
        self._num_nodes = 0

    def run(self) -> ClearanceResult:
        """Return the result of the proof, proven or not.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
        """
        violation = self._static_violation()
        if violation is not None:
            return self._pair_result(*violation)
        if len(self._moving_pairs) == 0:
            return self._proven_result(np.inf)
        for time in (0.0, self._request.trajectory.duration):
            self._measure_nearest(time)
        heap = [Node(-np.inf, 0, self._segments.whole, self._moving_pairs)]
        while heap:
            node = heappop(heap)
            outcome = self._check_node(node)
            if isinstance(outcome, UnprovenPair):
                return self._refused_result(outcome)
            for child in outcome:
                heappush(heap, child)
        return self._proven_result(self._refine_minimum())

    def _check_node(self, node: Node) -> list[Node] | UnprovenPair:
        """Decide the pairs on a segment as far as possible; return nodes for the undecided ones."""
        approaches = self._go_to_center(node.segment, node.undecided)
        largest_approach = float(approaches.max())
        if not np.isfinite(largest_approach):
            return UnprovenPair(
                int(node.undecided[np.argmax(approaches)]), np.inf, np.inf, node.segment.time
            )
        is_exhausted = _is_short(node.segment) or self._num_nodes > self._max_segments
        if largest_approach > _MAX_APPROACH and not is_exhausted:
            return self._split(node, node.undecided, node.lower_bound, node.proven_distance)
        required = self._required[node.undecided]
        thresholds = approaches + required + 2 * _ROUNDING
        measured = self._measure(node.undecided, thresholds, node.segment.time)
        if (measured.distances <= required).any():
            worst = int(np.argmin(measured.distances - required))
            return self._unproven_pair(measured, worst, 0.0, node.segment.time)
        lower = measured.lower_bounds - approaches
        signed_margins = lower - required
        is_decided = signed_margins > _ROUNDING
        proven_distance = min(node.proven_distance, float(lower[is_decided].min(initial=np.inf)))
        if is_decided.all():
            self._leaves.append(
                Node(proven_distance, node.number, node.segment, node.undecided, proven_distance)
            )
            return []
        if is_exhausted:
            worst = int(np.argmin(signed_margins))
            uncertainty = float(measured.distances[worst] - lower[worst])
            return self._unproven_pair(measured, worst, uncertainty, node.segment.time)
        return self._split(
            node, node.undecided[~is_decided], float(signed_margins.min()), proven_distance
        )

    def _unproven_pair(
        self, measured: MeasuredDistances, i: int, uncertainty: float, time: float
    ) -> UnprovenPair:
        return UnprovenPair(int(measured.pairs[i]), float(measured.distances[i]), uncertainty, time)

    def _split(
        self, node: Node, pairs: Indices, lower_bound: float, proven_distance: float
    ) -> list[Node]:
        children: list[Node] = []
        for half in self._segments.halves(node.segment):
            self._num_nodes += 1
            children.append(Node(lower_bound, self._num_nodes, half, pairs, proven_distance))
        return children

    def _refine_minimum(self) -> float:
        """Halve segments that may contain a smaller distance; return a bound on the smallest."""
        leaves = self._leaves
        heapify(leaves)
        max_configurations = self._closest.num_configurations + _REFINEMENT_SEGMENTS
        while self._closest.num_configurations < max_configurations:
            distance = self._closest.nearest.distance
            target = distance - max(_RESOLUTION, _RELATIVE_RESOLUTION * distance)
            segment = leaves[0].segment
            if leaves[0].lower_bound >= target or _is_short(segment):
                break
            node = heappop(leaves)
            for child in self._split(
                node, self._moving_pairs, node.lower_bound, node.proven_distance
            ):
                approaches = self._go_to_center(child.segment, child.undecided)
                thresholds = approaches + (target + 2 * _ROUNDING)
                measured = self._measure(child.undecided, thresholds, child.segment.time)
                child.lower_bound = max(
                    child.lower_bound, float((measured.lower_bounds - approaches).min())
                )
                heappush(leaves, child)
        return leaves[0].lower_bound

    def _go_to_center(self, segment: Segment, pairs: Indices) -> Array:
        """Put the group at a segment's centre; return the largest approach of each pair [m]."""
        if self._num_nodes % 8 == 0:
            self._deadline.check("certify")
        self._distances.set_positions(segment.center)
        return self._distances.max_approaches(segment, pairs)

    def _measure(self, pairs: Indices, thresholds: Array, time: float) -> MeasuredDistances:
        measured = self._distances.measure(pairs, thresholds)
        self._closest.update(pairs, measured.distances, time)
        return measured

    def _sample(self, within: float, time: float) -> int:
        """Measure all near pairs at an instant; return their number."""
        self._distances.set_positions(self._request.trajectory.positions(np.array([time]))[0])
        pairs, distances = self._distances.pairs_within(within)
        self._closest.update(pairs, distances, time)
        return len(pairs)

    def _measure_nearest(self, time: float) -> None:
        """Measure the nearest pair at an instant, at any distance."""
        for horizon in _HORIZONS:
            if self._sample(horizon, time):
                return

    def _static_violation(self) -> tuple[int, float, float, float] | None:
        """Return pair, distance, uncertainty and time of a violation among static pairs, or None.

        Static pairs are measured once. Contact between them is no violation if the margin is zero.
        """
        static = np.flatnonzero(~self._pairs.is_moved)
        required = self._pairs.margins[static] - MARGIN_TOLERANCE
        measured = self._distances.measure(static, required)
        signed_margins = measured.lower_bounds - required
        if not (signed_margins < 0).any():
            return None
        worst = int(np.argmin(signed_margins))
        distance, lower = float(measured.distances[worst]), float(measured.lower_bounds[worst])
        return int(static[worst]), distance, max(distance - lower, 0.0), 0.0

    def _proven_result(self, lower_bound: float) -> ClearanceResult:
        nearest = self._closest.nearest.distance
        resolution = max(0.0, nearest - lower_bound) if np.isfinite(nearest) else 0.0
        return self._result(*self._tightest_check(resolution, passed=True))

    def _refused_result(self, unproven: UnprovenPair) -> ClearanceResult:
        """Return the result of a failed proof; for a collision, with the worst one at samples."""
        if unproven.distance <= self._required[unproven.pair]:
            within = max(self._request.margins.largest, 0.0)
            for time in np.linspace(0.0, self._request.trajectory.duration, _NUM_INSTANTS):
                self._sample(within, float(time))
            return self._result(*self._tightest_check(0.0, passed=False))
        return self._pair_result(
            unproven.pair, unproven.distance, unproven.uncertainty, unproven.time
        )

    def _pair_result(
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

    def _tightest_check(self, resolution: float, *, passed: bool) -> tuple[Check, WitnessPoint]:
        """Return the check and the witness point of the pair with the smallest reserve."""
        tightest = self._closest.tightest
        check = Check(
            name="clearance",
            value=tightest.distance,
            bound=tightest.margin,
            unit="m",
            resolution=resolution,
            passed=passed,
            where=tightest.where,
            time=tightest.time,
        )
        return check, tightest.witness

    def _result(self, check: Check, reported: WitnessPoint) -> ClearanceResult:
        nearest = self._closest.nearest.witness
        return ClearanceResult(
            check, nearest, reported, self._num_nodes + 1, self._closest.num_configurations
        )


def _is_short(segment: Segment) -> bool:
    return segment.is_within_piece and segment.end - segment.begin < _MIN_SEGMENT_DURATION
