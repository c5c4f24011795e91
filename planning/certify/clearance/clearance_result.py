"""Clearance results: nodes of the search, unproven pairs, witness points and the verdict."""

from dataclasses import dataclass, field

import numpy as np
from pydrake.geometry import GeometryId

from planning.certify.intervals.joint_deviation import Segment
from planning.domain.arrays import Indices
from planning.domain.report.certificate import Check

# Tolerance below a margin: a start that keeps its margin exactly would otherwise be refused for
# rounding. A margin of zero means no contact, without tolerance [m].
MARGIN_TOLERANCE = 1e-6


@dataclass(frozen=True)
class WitnessPoint:
    """A pair of shapes at an instant, with their distance.

    Attributes:
        shapes: Drake's geometry ids of both; empty without a pair.
        bodies: Full names of their bodies, or two empty strings.
        distance: Measured signed distance [m], infinite without a pair.
        time: Instant [s].
    """

    shapes: tuple[GeometryId, ...] = ()
    bodies: tuple[str, str] = ("", "")
    distance: float = np.inf
    time: float = 0.0


@dataclass(frozen=True)
class ClearanceResult:
    """Result of a clearance proof.

    Attributes:
        check: The verdict: distance and margin of the pair with the smallest reserve.
        nearest: The smallest signed distance at any evaluated instant.
        reported: The pair that the check reports.
        num_segments: Number of segments bounded.
        num_queries: Number of configurations at which distances were measured.
        is_decided: Whether the verdict is final: passed, or a pair violates its margin. If not,
            other distance queries or separating directions might prove the motion.
    """

    check: Check
    nearest: WitnessPoint
    reported: WitnessPoint
    num_segments: int
    num_queries: int
    is_decided: bool = True


@dataclass(order=True)
class Node:
    """Node of the best-first search: a segment and its undecided pairs, smallest bound first.

    Attributes:
        lower_bound: Lower bound on distance minus margin, or on the distance itself [m].
        number: Tie breaker, so that every run is the same.
        segment: The segment.
        undecided: Indices of the pairs not yet decided on it.
        proven_distance: Lower bound on the distances of the decided pairs [m].
    """

    lower_bound: float
    number: int
    segment: Segment = field(compare=False)
    undecided: Indices = field(compare=False)
    proven_distance: float = field(compare=False, default=np.inf)


@dataclass(frozen=True)
class UnprovenPair:
    """The pair at which the proof stopped: its margin is violated, or not proven to be kept."""

    pair: int
    distance: float
    uncertainty: float
    time: float
