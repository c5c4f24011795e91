"""Clearance on the whole interval, by conservative bisection.

The distance of two shapes at an instant, less how much nearer they can come until either end of a
segment, bounds their distance on the segment from below. Where the bound is above the margin the
segment is proven for that pair; the pairs that are left are looked at again on both halves. The
most suspicious segment is always next, so that a collision is found early. Afterwards the segments
that may hide a smaller distance than was seen are halved until the smallest one is known well.
"""

from dataclasses import dataclass, field
from heapq import heapify, heappop, heappush
from typing import Any

import numpy as np

from planning.certify.pair_distances import LEFT_OUT_TOLERANCE, Indices, Measured, PairDistances
from planning.certify.request import CertifyRequest
from planning.certify.segments import Segment, Segments
from planning.domain.certificate import Check
from planning.domain.deadline import Deadline
from planning.world.drake_model import DrakeModel

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Less than a margin by this is enough: a start that keeps its margin exactly would otherwise be
# refused for rounding. No margin means no contact, with nothing off [m].
MARGIN_SLACK = 1e-6
# Bounds are rounded by less than this [m].
_ROUNDING = 1e-9
# Segments shorter than this, or more of them, are given up as unproven [s].
_SHORTEST = 1e-7
_MOST_SEGMENTS = 20_000
# Segments in which shapes move more than this are halved unseen: near pairs are too many there [m].
_WIDE = 0.25
# How well the smallest distance is to be known [m], the larger of these, and what it may cost.
_RESOLUTION = 1e-3
_RELATIVE_RESOLUTION = 0.01
_TIGHTENING_SEGMENTS = 400
# Instants at which a refused motion is looked at for its worst collision.
_INSTANTS = 33
_HORIZONS = (0.05, 0.2, 1.0, 5.0, 1e6)


@dataclass(frozen=True)
class Clearance:
    """What was found of the clearance.

    Attributes:
        check: The verdict: distance and margin of the pair with the least to spare.
        min_clearance: Smallest signed distance at any instant looked at [m].
        pair: Between whom.
        time: When [s].
        intervals: Segments that were bounded.
        queries: Configurations at which distances were measured.
    """

    check: Check
    min_clearance: float
    pair: tuple[str, str]
    time: float
    intervals: int
    queries: int


@dataclass(order=True)
class _Node:
    """A segment that is not decided yet, or one that is; the least promising comes first.

    Attributes:
        floor: Lower bound on what distance exceeds the margin by, or on the distance itself [m].
        number: Breaks ties, so that every run is the same.
        segment: The segment.
        open: Pairs that are not decided on it.
        proven: Lower bound on the distances of the pairs that are [m].
    """

    floor: float
    number: int
    segment: Segment = field(compare=False)
    open: Indices = field(compare=False)
    proven: float = field(compare=False, default=np.inf)


@dataclass
class _Seen:
    """The pair that had the least of something."""

    least: float = np.inf
    distance: float = np.inf
    margin: float = 0.0
    pair: tuple[str, str] = ("", "")
    time: float = 0.0


@dataclass(frozen=True)
class _Refused:
    """Where the proof stopped: a pair that is too near, or cannot be shown to be far enough."""

    pair: int
    distance: float
    uncertainty: float
    time: float


def check_clearance(model: DrakeModel, request: CertifyRequest, deadline: Deadline) -> Clearance:
    """Prove, or fail to prove, that every pair of bodies keeps its margin throughout.

    Raises:
        DeadlineExceeded: Time ran out; nothing is proven.
        Canceled: Somebody asked for the end.
        ModelInvalid: A shape or joint of a kind that cannot be certified.
    """
    return _Proof(model, request, deadline).run()


class _Proof:
    """One proof in a context of its own."""

    def __init__(self, model: DrakeModel, request: CertifyRequest, deadline: Deadline) -> None:
        self._request, self._deadline = request, deadline
        self._distances = PairDistances(model, request)
        self._segments = Segments(request.trajectory)
        margins = self._distances.margins
        self._required = np.where(margins > 0, np.maximum(margins - MARGIN_SLACK, 0.0), margins)
        self._every = np.arange(self._distances.num_pairs)
        self._nearest, self._tightest = _Seen(), _Seen()
        self._leaves: list[_Node] = []
        self._number = self._queries = 0

    def run(self) -> Clearance:
        fixed = self._fixed_violation()
        if fixed is not None:
            return self._result(fixed)
        if self._distances.num_pairs == 0:
            return self._verdict(np.inf)
        for time in (0.0, self._request.trajectory.duration):
            self._look(time)
        heap = [_Node(-np.inf, 0, self._segments.whole, self._every)]
        while heap:
            node = heappop(heap)
            outcome = self._judge(node)
            if isinstance(outcome, _Refused):
                return self._refusal(outcome)
            for child in outcome:
                heappush(heap, child)
        return self._verdict(self._tighten())

    def _judge(self, node: _Node) -> list[_Node] | _Refused:
        """Decide what can be decided on a segment, and return what is left of it."""
        approaches = self._enter(node.segment, node.open)
        widest = float(approaches.max())
        if not np.isfinite(widest):
            return _Refused(
                int(node.open[np.argmax(approaches)]), np.inf, np.inf, node.segment.time
            )
        width = node.segment.end - node.segment.begin
        exhausted = width < _SHORTEST or self._number > _MOST_SEGMENTS
        if widest > _WIDE and not exhausted:
            return self._split(node, node.open, node.floor, node.proven)
        required = self._required[node.open]
        enough = float((approaches + required).max()) + 2 * LEFT_OUT_TOLERANCE
        measured = self._measure(node.open, enough, node.segment.time)
        if (measured.is_exact & (measured.distances <= required)).any():
            spare = np.where(measured.is_exact, measured.distances - required, np.inf)
            return self._refuse(measured, int(np.argmin(spare)), 0.0, node.segment.time)
        lower = measured.lower - approaches
        spare = lower - required
        decided = spare > _ROUNDING
        proven = min(node.proven, float(lower[decided].min(initial=np.inf)))
        if decided.all():
            self._leaves.append(_Node(proven, node.number, node.segment, node.open, proven))
            return []
        if exhausted:
            worst = int(np.argmin(spare))
            uncertainty = float(measured.distances[worst] - lower[worst])
            return self._refuse(measured, worst, uncertainty, node.segment.time)
        return self._split(node, node.open[~decided], float(spare.min()), proven)

    def _refuse(self, measured: Measured, i: int, uncertainty: float, time: float) -> _Refused:
        return _Refused(int(measured.pairs[i]), float(measured.distances[i]), uncertainty, time)

    def _split(self, node: _Node, rest: Indices, floor: float, proven: float) -> list[_Node]:
        children: list[_Node] = []
        for half in self._segments.halves(node.segment):
            self._number += 1
            children.append(_Node(floor, self._number, half, rest, proven))
        return children

    def _tighten(self) -> float:
        """Halve the segments that may hide a smaller distance; return a bound on the smallest."""
        leaves = self._leaves
        heapify(leaves)
        last = self._queries + _TIGHTENING_SEGMENTS
        while self._queries < last:
            distance = self._nearest.distance
            target = distance - max(_RESOLUTION, _RELATIVE_RESOLUTION * distance)
            segment = leaves[0].segment
            if leaves[0].floor >= target or segment.end - segment.begin < _SHORTEST:
                break
            node = heappop(leaves)
            for child in self._split(node, self._every, node.floor, node.proven):
                approaches = self._enter(child.segment, child.open)
                enough = float(approaches.max()) + target + 2 * LEFT_OUT_TOLERANCE
                measured = self._measure(child.open, enough, child.segment.time)
                child.floor = max(child.floor, float((measured.lower - approaches).min()))
                heappush(leaves, child)
        return leaves[0].floor

    def _enter(self, segment: Segment, pairs: Indices) -> Array:
        """Go to a segment's centre and return how much nearer the pairs can come within it."""
        if self._number % 8 == 0:
            self._deadline.check("certify")
        self._distances.go_to(segment.center)
        return self._distances.approaches(segment, pairs)

    def _measure(self, pairs: Indices, enough: float, time: float) -> Measured:
        self._queries += 1
        measured = self._distances.measure(pairs, enough)
        seen = measured.pairs[measured.is_exact]
        if len(seen):
            distances = measured.distances[measured.is_exact]
            self._remember(self._nearest, seen, distances, distances, time)
            spare = distances - self._required[seen]
            self._remember(self._tightest, seen, distances, spare, time)
        return measured

    def _remember(
        self, seen: _Seen, pairs: Indices, distances: Array, what: Array, time: float
    ) -> None:
        least = int(np.argmin(what))
        if what[least] < seen.least:
            seen.least, seen.distance = float(what[least]), float(distances[least])
            seen.margin = float(self._distances.margins[pairs[least]])
            seen.pair, seen.time = self._distances.names[pairs[least]], time

    def _look(self, time: float) -> None:
        """Measure the nearest pair at an instant, however far it is."""
        self._distances.go_to(self._request.trajectory.positions(np.array([time]))[0])
        for horizon in _HORIZONS:
            if self._measure(self._every, horizon, time).is_exact.any():
                return

    def _fixed_violation(self) -> Check | None:
        """Return a failed check if bodies between which nothing moves are too near."""
        self._queries += 1
        within = max(self._request.margins.largest, MARGIN_SLACK)
        for names, distance, margin in self._distances.fixed_distances(within):
            if distance < margin - MARGIN_SLACK:
                where = "-".join(names)
                return Check("clearance", distance, margin, "m", 0.0, passed=False, where=where)
        return None

    def _verdict(self, floor: float) -> Clearance:
        seen, nearest = self._tightest, self._nearest.distance
        gap = max(0.0, nearest - floor) if np.isfinite(nearest) else 0.0
        where = "-".join(seen.pair) if seen.pair[0] else ""
        distance, margin, time = seen.distance, seen.margin, seen.time
        return self._result(
            Check("clearance", distance, margin, "m", gap, passed=True, where=where, time=time)
        )

    def _refusal(self, refused: _Refused) -> Clearance:
        """Say where the proof stopped; of collisions, report the worst that a look around shows."""
        if refused.distance <= self._required[refused.pair]:
            within = max(self._request.margins.largest, 0.0)
            for time in np.linspace(0.0, self._request.trajectory.duration, _INSTANTS):
                self._distances.go_to(self._request.trajectory.positions(np.array([time]))[0])
                self._measure(self._every, within, float(time))
            seen = self._tightest
            where = "-".join(seen.pair)
            distance, margin, time = seen.distance, seen.margin, seen.time
            return self._result(
                Check("clearance", distance, margin, "m", 0.0, passed=False, where=where, time=time)
            )
        return self._result(
            Check(
                name="clearance",
                value=refused.distance,
                bound=float(self._distances.margins[refused.pair]),
                unit="m",
                resolution=refused.uncertainty,
                passed=False,
                where="-".join(self._distances.names[refused.pair]),
                time=refused.time,
            )
        )

    def _result(self, check: Check) -> Clearance:
        nearest = self._nearest
        return Clearance(
            check, nearest.distance, nearest.pair, nearest.time, self._number + 1, self._queries
        )
