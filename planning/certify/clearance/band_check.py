"""Band check: distances of pairs of shapes, with a lower bound for all, an upper for the least."""

from dataclasses import dataclass

import numpy as np

from planning.certify.clearance.pair_distances import Indices, PairDistances
from planning.certify.intervals.branch_and_bound import BoundResult, QuantityBound, bounded
from planning.certify.intervals.joint_deviation import Segment
from planning.certify.request import CertifyRequest
from planning.domain.report.certificate import Check
from planning.domain.request.constraint import DistanceBand
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Pairs are measured up to this much above the distance that matters [m].
_MARGIN = 0.01
# Bound on Drake's overestimate of distances: relative, and the same number absolute [m].
_OVERSTATED = 1e-3


def band_check(
    name: str, band: DistanceBand, model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> Check:
    """Return the check of the smallest distance, at the bound of the band with the least reserve.

    The lower bound is proven as in the clearance proof. The upper bound is simpler: the distance of
    two points on two shapes bounds theirs, and grows by no more than both move.
    """
    distances = PairDistances(model, request)
    rows = _banded(distances, band)
    low = bounded(_Nearness(distances, rows, band.min), -band.min, request, deadline)
    if not np.isfinite(band.max) or not low.passed:
        return _check(name, low, -1.0, -band.min)
    high = bounded(_Farness(distances, rows, band.max), band.max, request, deadline)
    if high.passed and -band.min - low.value < band.max - high.value:
        return _check(name, low, -1.0, -band.min)
    return _check(name, high, 1.0, band.max)


def _check(name: str, found: BoundResult, sign: float, bound: float) -> Check:
    # If no pair was near enough to be measured, the bound stands in for the value.
    value = found.value if np.isfinite(found.value) else found.top
    return Check(
        name=name,
        value=sign * value,
        bound=sign * bound,
        unit="m",
        resolution=found.top - value,
        passed=found.passed,
        where=found.where,
        time=found.time,
    )


def _banded(distances: PairDistances, band: DistanceBand) -> Indices:
    """Return the indices of the moving pairs of shapes that the band applies to."""
    pairs = distances.pairs
    first = distances.moved_bodies if band.bodies is None else set(band.bodies)
    second = None if band.to is None else set(band.to)

    def meets(a: str, b: str) -> bool:
        return a in first and (b not in first if second is None else b in second)

    meant = [meets(a, b) or meets(b, a) for a, b in pairs.names]
    return np.flatnonzero(np.array(meant, dtype=bool) & pairs.is_moved)


@dataclass(frozen=True)
class _Nearness:
    """The negated smallest distance, a quantity with an upper bound [m]."""

    distances: PairDistances
    rows: Indices
    min: float

    def look(self, segment: Segment) -> QuantityBound:
        self.distances.go_to(segment.center)
        approaches = self.distances.approaches(segment, self.rows)
        measured = self.distances.measure(self.rows, approaches + self.min + _MARGIN)
        nearest = int(np.argmin(measured.distances))
        pair = self.distances.pairs.names[self.rows[nearest]]
        floor = float((measured.lower - approaches).min())
        return QuantityBound(-float(measured.distances[nearest]), -floor, "-".join(pair))


@dataclass(frozen=True)
class _Farness:
    """The smallest distance, a quantity with an upper bound [m]."""

    distances: PairDistances
    rows: Indices
    max: float

    def look(self, segment: Segment) -> QuantityBound:
        self.distances.go_to(segment.center)
        approaches = self.distances.approaches(segment, self.rows)
        wanted = np.full(len(self.rows), self.max + _MARGIN)
        measured = self.distances.measure(self.rows, wanted)
        nearest = int(np.argmin(measured.distances))
        value = float(measured.distances[nearest])
        if not np.isfinite(value):
            return QuantityBound(float(measured.lower.min()), np.inf)
        pair = self.distances.pairs.names[self.rows[nearest]]
        uppers = measured.distances
        if value > self.max >= value - _OVERSTATED * (1 + value):
            uppers = np.array(uppers)
            uppers[nearest] = value = min(value, self.distances.closely(int(self.rows[nearest])))
        return QuantityBound(value, float((uppers + approaches).min()), "-".join(pair))
