"""Predicate check: a user predicate evaluated at samples of a trajectory, with their spacing.

A predicate is a black box: nothing is proven between the samples.
"""

import numpy as np

from planning.certify.intervals.joint_deviation import Segment, Segments
from planning.certify.request import CertifyRequest
from planning.domain.report.certificate import Check
from planning.domain.request.constraint import PathPredicate
from planning.domain.request.deadline import Deadline


def predicate_check(
    name: str, constraint: PathPredicate, request: CertifyRequest, deadline: Deadline
) -> Check:
    """Return the check that a predicate holds at samples of the trajectory, both ends included.

    Between two samples every configuration is within the resolution of one of them, measured as the
    root of the sum of squares of all joint rotations and translations.
    """
    resolution = constraint.resolution
    where = f"sampled every {resolution:g} rad or m"
    segments = Segments(request.trajectory)
    ends = [(0.0, request.trajectory.start), (request.trajectory.duration, request.trajectory.end)]
    for time, q in ends:
        if not constraint.predicate(q):
            return Check(name, 1.0, 0.0, "1", resolution, passed=False, where=where, time=time)
    pending = [segments.whole]
    num_segments = 0
    while pending:
        segment = pending.pop()
        num_segments += 1
        if num_segments % 64 == 0:
            deadline.check("certify")
        if segment.is_within_piece and _max_deviation(segment) <= resolution:
            if not constraint.predicate(segment.center):
                time = segment.time
                return Check(name, 1.0, 0.0, "1", resolution, passed=False, where=where, time=time)
        else:
            pending += reversed(segments.halves(segment))
    return Check(name, 0.0, 0.0, "1", resolution, passed=True, where=where)


def _max_deviation(segment: Segment) -> float:
    return float(np.sqrt((segment.max_rotation**2).sum() + (segment.max_translation**2).sum()))
