"""What a proof of clearance is made of: open ends, dead ends, and the finding."""

from dataclasses import dataclass, field

import numpy as np

from planning.certify.pair_distances import Indices
from planning.certify.segments import Segment
from planning.domain.certificate import Check

# Less than a margin by this is enough: a start that keeps its margin exactly would otherwise be
# refused for rounding. No margin means no contact, with nothing off [m].
MARGIN_SLACK = 1e-6


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
class Refused:
    """Where the proof stopped: a pair that is too near, or cannot be shown to be far enough."""

    pair: int
    distance: float
    uncertainty: float
    time: float
