"""What a proof of clearance is made of: open ends, dead ends, and the finding."""

from dataclasses import dataclass, field

import numpy as np
from pydrake.geometry import GeometryId

from planning.certify.clearance.pair_distances import Indices
from planning.certify.intervals.joint_deviation import Segment
from planning.domain.report.certificate import Check

# Less than a margin by this is enough: a start that keeps its margin exactly would otherwise be
# refused for rounding. No margin means no contact, with nothing off [m].
MARGIN_SLACK = 1e-6


@dataclass(frozen=True)
class WitnessPoint:
    """Two shapes at an instant.

    Attributes:
        shapes: Drake's names of both; none if there was no pair to look at.
        bodies: Full names of their bodies, or two empty ones.
        distance: Their signed distance as measured [m], infinite without a pair.
        time: When [s].
    """

    shapes: tuple[GeometryId, ...] = ()
    bodies: tuple[str, str] = ("", "")
    distance: float = np.inf
    time: float = 0.0


@dataclass(frozen=True)
class ClearanceResult:
    """What was found of the clearance.

    Attributes:
        check: The verdict: distance and margin of the pair with the least to spare.
        nearest: The smallest signed distance at any instant looked at.
        checked: The pair that the check tells of.
        intervals: Segments that were bounded.
        queries: Configurations at which distances were measured.
        is_decided: Whether other distances, or directions, would give the same verdict: it passed,
            or a pair is too near for certain.
    """

    check: Check
    nearest: WitnessPoint
    checked: WitnessPoint
    intervals: int
    queries: int
    is_decided: bool = True


@dataclass(order=True)
class Node:
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


@dataclass(frozen=True)
class UnprovenPair:
    """Where the proof stopped: a pair that is too near, or cannot be shown to be far enough."""

    pair: int
    distance: float
    uncertainty: float
    time: float
