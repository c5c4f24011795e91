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

from planning.certify.clearance.pair_distances import Indices, PairDistances
from planning.certify.intervals.branch_and_bound import (
    BoundResult,
    BoundTolerance,
    QuantityBound,
    bound_maximum,
)
from planning.certify.intervals.joint_deviation import Segment
from planning.certify.request import CertifyRequest
from planning.domain.request.deadline import Deadline
from planning.domain.request.robustness import MOST_DISPLACEMENT, MOST_ERROR, Robustness
from planning.world.drake_model import DrakeModel

# Segments on which shapes move more than this are halved without a distance query [m].
_WIDE = 0.25
_ROUNDING = 1e-9
# Search until the value is known to 1 % or 1e-4 [rad or m], with at most `looks` evaluations.
_FINENESS = BoundTolerance(share=0.01, least=1e-4, looks=800)


def robustness(model: DrakeModel, request: CertifyRequest, deadline: Deadline) -> Robustness:
    """Return the obstacle and joint errors under which the proof of a proven request still holds.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    distances = PairDistances(model, request)
    moved = np.flatnonzero(distances.pairs.is_moved)
    facing = np.array([i for i in moved if _is_obstacle(distances, request, int(i))], dtype=np.intp)
    obstacle = _ClearanceReserve(distances, facing, MOST_DISPLACEMENT, counts_joints=False)
    joint = _ClearanceReserve(distances, moved, MOST_ERROR, counts_joints=True)
    near, off = (
        bound_maximum(spare, _FINENESS, request, deadline) if len(spare.pairs) else _NOTHING
        for spare in (obstacle, joint)
    )
    return Robustness(
        obstacle_displacement=_allowed(near, MOST_DISPLACEMENT),
        obstacle_pair=_names(near),
        obstacle_time=near.time,
        joint_error=_allowed(off, MOST_ERROR),
        joint_pair=_names(off),
        joint_time=off.time,
    )


_NOTHING = BoundResult(-np.inf, -np.inf, passed=True, where="", time=0.0)


def _allowed(found: BoundResult, most: float) -> float:
    return float(np.clip(-found.top - _ROUNDING, 0.0, most))


def _names(found: BoundResult) -> tuple[str, str]:
    first, _, second = found.where.partition(" ")
    return first, second


def _is_obstacle(distances: PairDistances, request: CertifyRequest, pair: int) -> bool:
    """Return whether the group moves exactly one body of a pair, and the other is an obstacle."""
    a, b = distances.pairs.names[pair]
    both = {a, b} <= distances.moved_bodies
    return not both and not request.margins.are_of_one_robot(a, b)


class _ClearanceReserve:
    """The reserve of the tightest pair, negated: a quantity with an upper bound."""

    def __init__(
        self, distances: PairDistances, pairs: Indices, most: float, *, counts_joints: bool
    ) -> None:
        self.pairs = pairs
        self._distances, self._counts_joints = distances, counts_joints
        self._margins = distances.pairs.margins[pairs]
        self._least = most

    def look(self, segment: Segment) -> QuantityBound:
        distances = self._distances
        distances.go_to(segment.center)
        approaches = distances.approaches(segment, self.pairs)
        if not approaches.max() <= _WIDE:
            return QuantityBound(-np.inf, np.inf)
        slopes = np.ones(len(self.pairs))
        if self._counts_joints:
            slopes = np.maximum(distances.sensitivities(self.pairs), 1e-12)
        # A pair with more reserve than the smallest so far need not be measured accurately.
        wanted = approaches + self._margins + slopes * self._least + 2 * _ROUNDING
        lower = distances.measure(self.pairs, wanted).lower
        here = (lower - self._margins) / slopes
        all_over = (lower - approaches - self._margins) / slopes
        tightest = int(np.argmin(here))
        self._least = min(self._least, max(float(here[tightest]), 0.0))
        where = " ".join(distances.pairs.names[self.pairs[tightest]])
        return QuantityBound(-float(here[tightest]), -float(all_over.min()), where)
