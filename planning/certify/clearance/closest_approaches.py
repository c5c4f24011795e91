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
        value: The smallest value [m].
        distance: Signed distance of the pair [m].
        margin: Required distance of the pair [m].
        names: Full names of its bodies.
        shapes: Drake's geometry ids of its shapes, or none.
        time: Instant [s].
    """

    value: float = np.inf
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
    def witness(self) -> WitnessPoint:
        """The pair as a witness point."""
        return WitnessPoint(self.shapes, self.names, self.distance, self.time)


@dataclass
class ClosestApproaches:
    """The closest approaches over all configurations evaluated so far.

    Attributes:
        pairs: All pairs.
        nearest: The pair with the smallest distance.
        tightest: The pair with the smallest distance minus margin.
        num_configurations: Number of configurations evaluated.
    """

    pairs: CandidatePairs
    nearest: ClosestApproach = field(default_factory=ClosestApproach)
    tightest: ClosestApproach = field(default_factory=ClosestApproach)
    num_configurations: int = 0

    def update(self, pairs: Indices, distances: Array, time: float) -> None:
        """Update with the distances [m] at one configuration; infinite means not measured."""
        self.num_configurations += 1
        is_measured = distances < np.inf
        if is_measured.any():
            pairs, distances = pairs[is_measured], distances[is_measured]
            self._update_approach(self.nearest, pairs, distances, distances, time)
            signed_margins = distances - self.pairs.margins[pairs]
            self._update_approach(self.tightest, pairs, distances, signed_margins, time)

    def _update_approach(
        self,
        approach: ClosestApproach,
        pairs: Indices,
        distances: Array,
        values: Array,
        time: float,
    ) -> None:
        smallest = int(np.argmin(values))
        if values[smallest] < approach.value:
            approach.value, approach.distance = float(values[smallest]), float(distances[smallest])
            approach.margin = float(self.pairs.margins[pairs[smallest]])
            approach.names, approach.time = self.pairs.names[pairs[smallest]], time
            approach.shapes = self.pairs.ids[pairs[smallest]]
