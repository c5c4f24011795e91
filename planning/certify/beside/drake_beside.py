"""Proof for two motions with Drake's distances, where there is no kernel for the scene.

The method is explained in `beside_check`; of the bounds it has those of first order alone.
"""

from dataclasses import dataclass, field, replace
from heapq import heappop, heappush

import numpy as np

from planning.certify.beside.beside_request import BesideRequest, BesideResult, moved_bodies
from planning.certify.clearance.clearance_result import MARGIN_TOLERANCE
from planning.certify.clearance.pair_distances import MeasuredDistances, PairDistances
from planning.certify.intervals.joint_deviation import Segment, Segments
from planning.domain.arrays import Array, Indices
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Rounding error of bounds is less than this [m].
_ROUNDING = 1e-9
# Shortest segment [s] and largest number of nodes; beyond these the proof ends as unproven.
_MIN_SEGMENT_DURATION = 1e-7
_MAX_NODES = 20_000
# Nodes on which shapes move more than this are halved without a distance query [m].
_MAX_APPROACH = 0.25
# Distance up to which pairs are measured where both motions begin [m].
_HORIZON = 0.2


@dataclass(order=True)
class _Node:
    """A segment of either motion, and the pairs undecided on both; the smallest bound is first."""

    lower_bound: float
    number: int
    segments: tuple[Segment, Segment] = field(compare=False)
    undecided: Indices = field(compare=False)

    @property
    def is_short(self) -> tuple[bool, bool]:
        """Whether each segment is too short to be halved."""
        first, second = self.segments
        return _is_short(first), _is_short(second)


class DrakeBeside:
    """One proof for two motions, in a Drake context of its own."""

    def __init__(self, model: DrakeModel, request: BesideRequest, deadline: Deadline) -> None:
        """Prepare a proof.

        Raises:
            ModelInvalid: A shape or joint of a kind that cannot be certified.
        """
        self._deadline = deadline
        self._distances = PairDistances(model, request)
        self._pairs = self._distances.pairs
        self._segments = tuple(Segments(trajectory) for trajectory in request.trajectories)
        margins = self._pairs.margins
        self._required = np.where(margins > 0, np.maximum(margins - MARGIN_TOLERANCE, 0.0), margins)
        first, second = (moved_bodies(model, group) for group in request.groups)
        self._shared = np.array(
            [
                i
                for i, (a, b) in enumerate(self._pairs.names)
                if (a in first and b in second) or (a in second and b in first)
            ],
            dtype=np.intp,
        )
        self._worst: tuple[float, int, float, tuple[float, float]] = (np.inf, -1, np.inf, (0, 0))
        self._num_nodes = 0

    def run(self) -> BesideResult:
        """Return the result, proven or not.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
        """
        if len(self._shared) == 0:
            return self._result("PROVEN")
        self._measure(self._shared, self._required[self._shared] + _HORIZON, (0.0, 0.0))
        whole = self._segments[0].whole, self._segments[1].whole
        heap = [_Node(-np.inf, 0, whole, self._shared)]
        while heap:
            outcome = self._check_node(heappop(heap))
            if isinstance(outcome, str):
                return self._result(outcome)
            for child in outcome:
                heappush(heap, child)
        return self._result("PROVEN")

    def _check_node(self, node: _Node) -> list[_Node] | str:
        """Decide pairs where possible; return nodes for the others, or the outcome of the proof."""
        if self._num_nodes % 8 == 0:
            self._deadline.check("certify")
        first, second = node.segments
        self._distances.set_positions(np.concatenate([first.center, second.center]))
        shares = [self._share(node, which) for which in (0, 1)]
        gaps = self._distances.sphere_distances(node.undecided)
        is_open = gaps - shares[0] - shares[1] - self._required[node.undecided] <= _ROUNDING
        if not is_open.any():
            return []
        node = replace(node, undecided=node.undecided[is_open])
        shares = [share[is_open] for share in shares]
        approaches = shares[0] + shares[1]
        is_exhausted = all(node.is_short) or self._num_nodes > _MAX_NODES
        if approaches.max() > _MAX_APPROACH and not is_exhausted:
            worst = int(np.argmax(approaches))
            return self._halves(node, (shares[0][worst], shares[1][worst]), node.undecided)
        required = self._required[node.undecided]
        thresholds = approaches + required + 2 * _ROUNDING
        measured = self._measure(node.undecided, thresholds, (first.time, second.time))
        if (measured.distances <= required).any():
            return self._end("TOO_NEAR", measured, measured.distances - required, node)
        reserves = measured.lower_bounds - approaches - required
        is_open = reserves <= _ROUNDING
        if not is_open.any():
            return []
        if is_exhausted:
            return self._end("UNPROVEN", measured, reserves, node)
        worst = int(np.argmin(reserves))
        node = replace(node, lower_bound=float(reserves[worst]))
        return self._halves(node, (shares[0][worst], shares[1][worst]), node.undecided[is_open])

    def _share(self, node: _Node, which: int) -> Array:
        """Return the largest approach of each undecided pair by the deviation of one motion [m]."""
        first, second = node.segments
        factors = (1.0, 0.0) if which == 0 else (0.0, 1.0)
        rotations, translations = (
            np.concatenate([factors[0] * getattr(first, name), factors[1] * getattr(second, name)])
            for name in ("max_rotation", "max_translation")
        )
        both = replace(first, max_rotation=rotations, max_translation=translations)
        return self._distances.max_approaches(both, node.undecided)

    def _halves(self, node: _Node, shares: tuple[float, float], undecided: Indices) -> list[_Node]:
        """Halve the motion with the larger share in a pair's approach, unless it is short."""
        which = 0 if shares[0] >= shares[1] else 1
        if node.is_short[which]:
            which = 1 - which
        children: list[_Node] = []
        for half in self._segments[which].halves(node.segments[which]):
            self._num_nodes += 1
            both = (half, node.segments[1]) if which == 0 else (node.segments[0], half)
            children.append(_Node(node.lower_bound, self._num_nodes, both, undecided))
        return children

    def _measure(
        self, pairs: Indices, thresholds: Array, times: tuple[float, float]
    ) -> MeasuredDistances:
        measured = self._distances.measure(pairs, thresholds)
        reserves = measured.distances - self._pairs.margins[pairs]
        nearest = int(np.argmin(reserves))
        if reserves[nearest] < self._worst[0]:
            distance = float(measured.distances[nearest])
            self._worst = float(reserves[nearest]), int(pairs[nearest]), distance, times
        return measured

    def _end(self, outcome: str, measured: MeasuredDistances, reserves: Array, node: _Node) -> str:
        """Note the pair at which the proof ends, and return its outcome."""
        i = int(np.argmin(reserves))
        times = node.segments[0].time, node.segments[1].time
        self._worst = (
            float(reserves[i]),
            int(measured.pairs[i]),
            float(measured.distances[i]),
            times,
        )
        return outcome

    def _result(self, outcome: str) -> BesideResult:
        _, pair, distance, times = self._worst
        return BesideResult(
            outcome=outcome,
            bodies=self._pairs.names[pair] if pair >= 0 else ("", ""),
            distance=distance,
            margin=float(self._pairs.margins[pair]) if pair >= 0 else 0.0,
            times=times,
            num_segments=self._num_nodes + 1,
        )


def _is_short(segment: Segment) -> bool:
    return segment.is_within_piece and segment.end - segment.begin < _MIN_SEGMENT_DURATION
