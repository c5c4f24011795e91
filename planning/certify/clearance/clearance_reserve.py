"""Clearance reserve: errors of obstacle poses and joint positions that the proof tolerates.

Let d_p be a proven lower bound on the distance of pair p at the centre of a segment, A_p(sigma) the
largest approach of its two shapes for joint deviations sigma, and m_p the pair's margin. With an
obstacle whose points are displaced by e, the pair keeps its margin all over the segment if

    e <= d_p - A_p(sigma) - m_p.

A joint with an error e deviates by sigma + e from the centre, and as a chord grows no faster than
its arc, A_p(sigma + e) <= A_p(sigma) + e S_p with S_p the sum of the lever arms between the two
shapes (1 for prismatic joints). So the pair keeps its margin if

    e <= (d_p - A_p(sigma) - m_p) / S_p.

Both are bounded along the whole trajectory by best-first branch and bound.
"""

import numpy as np

from planning.certify.clearance.pair_distances import PairDistances
from planning.certify.intervals.branch_and_bound import (
    BoundResult,
    BoundTolerance,
    QuantityBound,
    bound_maximum,
)
from planning.certify.intervals.joint_deviation import Segment
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Indices
from planning.domain.request.deadline import Deadline
from planning.domain.request.robustness import MAX_DISPLACEMENT, MAX_JOINT_ERROR, Robustness
from planning.world.drake_model import DrakeModel

# Segments on which shapes move more than this are halved without a distance query [m].
_MAX_APPROACH = 0.25
_ROUNDING = 1e-9
# Search until the value is known to 1 % or 1e-4 [rad or m], with at most this many evaluations.
_TOLERANCE = BoundTolerance(relative=0.01, absolute=1e-4, max_segments=800)


def robustness(model: DrakeModel, request: CertifyRequest, deadline: Deadline) -> Robustness:
    """Return the obstacle and joint errors under which the proof of a proven request still holds.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    distances = PairDistances(model, request)
    moving_pairs = np.flatnonzero(distances.pairs.is_moved)
    obstacle_pairs = np.array(
        [i for i in moving_pairs if _is_obstacle(distances, request, int(i))], dtype=np.intp
    )
    obstacle = _ClearanceReserve(distances, obstacle_pairs, MAX_DISPLACEMENT, counts_joints=False)
    joint = _ClearanceReserve(distances, moving_pairs, MAX_JOINT_ERROR, counts_joints=True)
    obstacle_result, joint_result = (
        bound_maximum(reserve, _TOLERANCE, request, deadline) if len(reserve.pairs) else _NO_PAIRS
        for reserve in (obstacle, joint)
    )
    return Robustness(
        obstacle_displacement=_allowed(obstacle_result, MAX_DISPLACEMENT),
        obstacle_pair=_names(obstacle_result),
        obstacle_time=obstacle_result.time,
        joint_error=_allowed(joint_result, MAX_JOINT_ERROR),
        joint_pair=_names(joint_result),
        joint_time=joint_result.time,
    )


_NO_PAIRS = BoundResult(-np.inf, -np.inf, passed=True, where="", time=0.0)


def _allowed(result: BoundResult, maximum: float) -> float:
    return float(np.clip(-result.upper_bound - _ROUNDING, 0.0, maximum))


def _names(result: BoundResult) -> tuple[str, str]:
    first, _, second = result.where.partition(" ")
    return first, second


def _is_obstacle(distances: PairDistances, request: CertifyRequest, pair: int) -> bool:
    """Return whether the group moves exactly one body of a pair, and the other is an obstacle."""
    a, b = distances.pairs.names[pair]
    both = {a, b} <= distances.moved_bodies
    return not both and not request.margins.are_of_one_robot(a, b)


class _ClearanceReserve:
    """The reserve of the tightest pair, negated: a quantity with an upper bound."""

    def __init__(
        self, distances: PairDistances, pairs: Indices, maximum: float, *, counts_joints: bool
    ) -> None:
        self.pairs = pairs
        self._distances, self._counts_joints = distances, counts_joints
        self._margins = distances.pairs.margins[pairs]
        self._smallest = maximum

    def evaluate(self, segment: Segment) -> QuantityBound:
        distances = self._distances
        distances.set_positions(segment.center)
        approaches = distances.max_approaches(segment, self.pairs)
        if not approaches.max() <= _MAX_APPROACH:
            return QuantityBound(-np.inf, np.inf)
        slopes = np.ones(len(self.pairs))
        if self._counts_joints:
            slopes = np.maximum(distances.sensitivities(self.pairs), 1e-12)
        # A pair with more reserve than the smallest so far need not be measured accurately.
        thresholds = approaches + self._margins + slopes * self._smallest + 2 * _ROUNDING
        lower = distances.measure(self.pairs, thresholds).lower_bounds
        reserves = (lower - self._margins) / slopes
        reserve_bounds = (lower - approaches - self._margins) / slopes
        tightest = int(np.argmin(reserves))
        self._smallest = min(self._smallest, max(float(reserves[tightest]), 0.0))
        where = " ".join(distances.pairs.names[self.pairs[tightest]])
        return QuantityBound(-float(reserves[tightest]), -float(reserve_bounds.min()), where)
