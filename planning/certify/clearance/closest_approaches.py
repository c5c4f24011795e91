"""ClosestApproaches: the smallest distances and margin reserves so far, with their instants."""

from dataclasses import dataclass, field

import numpy as np
from pydrake.geometry import GeometryId

from planning.certify.clearance.candidate_pairs import CandidatePairs
from planning.certify.clearance.clearance_result import WitnessPoint
from planning.domain.arrays import Array, Indices


@dataclass
class ClosestApproach:
    """The pair with the smallest value of a quantity (distance, or distance minus margin).

    Attributes:
        least: The smallest value [m].
        distance: Signed distance of the pair [m].
        margin: Required distance of the pair [m].
        names: Full names of its bodies.
        shapes: Drake's geometry ids of its shapes, or none.
        time: Instant [s].
    """

    least: float = np.inf
    distance: float = np.inf
    margin: float = 0.0
    names: tuple[str, str] = ("", "")
    time: float = 0.0
    shapes: tuple[GeometryId, ...] = ()

    @property
    def where(self) -> str:
        """Both body names, joined by a hyphen; empty without a pair."""
        return "-".join(self.names) if self.names[0] else ""

    @property
    def spot(self) -> WitnessPoint:
        """The pair as a witness point."""
        return WitnessPoint(self.shapes, self.names, self.distance, self.time)


@dataclass
class ClosestApproaches:
    """The closest approaches over all configurations evaluated so far.

    Attributes:
        pairs: All pairs.
        nearest: The pair with the smallest distance.
        tightest: The pair with the smallest distance minus margin.
        count: Number of configurations evaluated.
    """

    pairs: CandidatePairs
    nearest: ClosestApproach = field(default_factory=ClosestApproach)
    tightest: ClosestApproach = field(default_factory=ClosestApproach)
    count: int = 0

    def see(self, pairs: Indices, distances: Array, time: float) -> None:
        """Update with the distances [m] at one configuration; infinite means not measured."""
        self.count += 1
        seen = distances < np.inf
        if seen.any():
            pairs, distances = pairs[seen], distances[seen]
            self._note(self.nearest, pairs, distances, distances, time)
            spare = distances - self.pairs.margins[pairs]
            self._note(self.tightest, pairs, distances, spare, time)

    def _note(
        self, sighting: ClosestApproach, pairs: Indices, distances: Array, what: Array, time: float
    ) -> None:
        least = int(np.argmin(what))
        if what[least] < sighting.least:
            sighting.least, sighting.distance = float(what[least]), float(distances[least])
            sighting.margin = float(self.pairs.margins[pairs[least]])
            sighting.names, sighting.time = self.pairs.names[pairs[least]], time
            sighting.shapes = self.pairs.ids[pairs[least]]
