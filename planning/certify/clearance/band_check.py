"""Band check: distances of pairs of shapes, with a lower bound for all, an upper for the least."""

from dataclasses import dataclass

import numpy as np

from planning.certify.clearance.pair_distances import PairDistances
from planning.certify.intervals.branch_and_bound import BoundResult, QuantityBound, prove_bound
from planning.certify.intervals.joint_deviation import Segment
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Indices
from planning.domain.report.certificate import Check
from planning.domain.request.constraint import DistanceBand
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Pairs are measured up to this much above the distance that matters [m].
_QUERY_MARGIN = 0.01
# Bound on Drake's overestimate of distances: relative, and the same number absolute [m].
_MAX_OVERSTATEMENT = 1e-3


def band_check(
    name: str, band: DistanceBand, model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> Check:
    """Return the check of the smallest distance, at the bound of the band with the least reserve.

    The lower bound is proven as in the clearance proof. The upper bound is simpler: the distance of
    two points on two shapes bounds theirs, and grows by no more than both move.
    """
    distances = PairDistances(model, request)
    rows = _constrained_pairs(distances, band)
    low = prove_bound(_NegatedDistance(distances, rows, band.min), -band.min, request, deadline)
    if not np.isfinite(band.max) or not low.passed:
        return _check(name, low, -1.0, -band.min)
    high = prove_bound(_SmallestDistance(distances, rows, band.max), band.max, request, deadline)
    if high.passed and -band.min - low.value < band.max - high.value:
        return _check(name, low, -1.0, -band.min)
    return _check(name, high, 1.0, band.max)


def _check(name: str, result: BoundResult, sign: float, bound: float) -> Check:
    # If no pair was near enough to be measured, the bound stands in for the value.
    value = result.value if np.isfinite(result.value) else result.upper_bound
    return Check(
        name=name,
        value=sign * value,
        bound=sign * bound,
        unit="m",
        resolution=result.upper_bound - value,
        passed=result.passed,
        where=result.where,
        time=result.time,
    )


def _constrained_pairs(distances: PairDistances, band: DistanceBand) -> Indices:
    """Return the indices of the moving pairs of shapes that the band applies to."""
    pairs = distances.pairs
    first = distances.moved_bodies if band.bodies is None else set(band.bodies)
    second = None if band.to is None else set(band.to)

    def applies_to(a: str, b: str) -> bool:
        return a in first and (b not in first if second is None else b in second)

    is_constrained = [applies_to(a, b) or applies_to(b, a) for a, b in pairs.names]
    return np.flatnonzero(np.array(is_constrained, dtype=bool) & pairs.is_moved)


@dataclass(frozen=True)
class _NegatedDistance:
    """The negated smallest distance, a quantity with an upper bound [m]."""

    distances: PairDistances
    rows: Indices
    min: float

    def evaluate(self, segment: Segment) -> QuantityBound:
        self.distances.set_positions(segment.center)
        approaches = self.distances.max_approaches(segment, self.rows)
        measured = self.distances.measure(self.rows, approaches + self.min + _QUERY_MARGIN)
        nearest = int(np.argmin(measured.distances))
        pair = self.distances.pairs.names[self.rows[nearest]]
        lower_bound = float((measured.lower_bounds - approaches).min())
        return QuantityBound(-float(measured.distances[nearest]), -lower_bound, "-".join(pair))


@dataclass(frozen=True)
class _SmallestDistance:
    """The smallest distance, a quantity with an upper bound [m]."""

    distances: PairDistances
    rows: Indices
    max: float

    def evaluate(self, segment: Segment) -> QuantityBound:
        self.distances.set_positions(segment.center)
        approaches = self.distances.max_approaches(segment, self.rows)
        thresholds = np.full(len(self.rows), self.max + _QUERY_MARGIN)
        measured = self.distances.measure(self.rows, thresholds)
        nearest = int(np.argmin(measured.distances))
        value = float(measured.distances[nearest])
        if not np.isfinite(value):
            return QuantityBound(float(measured.lower_bounds.min()), np.inf)
        pair = self.distances.pairs.names[self.rows[nearest]]
        upper_bounds = measured.distances
        if value > self.max >= value - _MAX_OVERSTATEMENT * (1 + value):
            upper_bounds = np.array(upper_bounds)
            upper_bounds[nearest] = value = min(
                value, self.distances.tight_upper_bound(int(self.rows[nearest]))
            )
        return QuantityBound(value, float((upper_bounds + approaches).min()), "-".join(pair))
