"""ClosestApproaches: the smallest distances that were seen, and when."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydrake.geometry import GeometryId

from planning.certify.clearance.candidate_pairs import CandidatePairs
from planning.certify.clearance.clearance_result import WitnessPoint

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]


@dataclass
class ClosestApproach:
    """The pair that had the least of something.

    Attributes:
        least: Of what [m].
        distance: Its signed distance [m].
        margin: The distance demanded of it [m].
        names: Its bodies.
        shapes: Drake's names of its shapes, or none.
        time: When [s].
    """

    least: float = np.inf
    distance: float = np.inf
    margin: float = 0.0
    names: tuple[str, str] = ("", "")
    time: float = 0.0
    shapes: tuple[GeometryId, ...] = ()

    @property
    def where(self) -> str:
        """The bodies, as one name."""
        return "-".join(self.names) if self.names[0] else ""

    @property
    def spot(self) -> WitnessPoint:
        """Where it was."""
        return WitnessPoint(self.shapes, self.names, self.distance, self.time)


@dataclass
class ClosestApproaches:
    """What was seen so far.

    Attributes:
        pairs: All pairs.
        nearest: The pair with the smallest distance.
        tightest: The pair with the least distance to spare over its margin.
        count: Configurations that were looked at.
    """

    pairs: CandidatePairs
    nearest: ClosestApproach = field(default_factory=ClosestApproach)
    tightest: ClosestApproach = field(default_factory=ClosestApproach)
    count: int = 0

    def see(self, pairs: Indices, distances: Array, time: float) -> None:
        """Take note of distances [m], infinite where none was measured, at one configuration."""
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
