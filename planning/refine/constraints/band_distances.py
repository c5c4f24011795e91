"""Distance band as distances: no pair below the lower bound, the nearest pair within the upper."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.refine.constraints.distance_query import DistanceRows, make_distance_query
from planning.refine.curves.chart import Chart
from planning.world.constraints.band_constraint import BandConstraint

# Required distance of pairs outside the band: they never count as near [m].
_NO_THRESHOLD = -1e3


@dataclass(frozen=True)
class BandThresholds:
    """Pair thresholds that select a band's pairs and no others.

    Attributes:
        pairs: The band's pairs, by full names in sorted order.
    """

    pairs: frozenset[tuple[str, str]]

    @property
    def override_pairs(self) -> frozenset[tuple[str, str]]:
        """The band's pairs."""
        return self.pairs

    def threshold(self, body_a: str, body_b: str) -> float:
        """Return the required distance: 0 for the band's pairs, very negative for others [m]."""
        return 0.0 if (min(body_a, body_b), max(body_a, body_b)) in self.pairs else _NO_THRESHOLD


class BandDistanceQuery:
    """Signed margins to both bounds of a distance band.

    Every pair has a margin of its own to the lower bound. The upper bound counts for the nearest
    pair only: as long as that pair stays near, the band is kept, wherever the others are.
    """

    def __init__(self, constraint: BandConstraint, chart: Chart) -> None:
        """Prepare, with configurations as coordinates of a chart."""
        self._lower_bound = constraint.min + constraint.margin
        self._upper_bound = constraint.max - constraint.margin
        thresholds = BandThresholds(constraint.pairs)
        self._distance_query = chart.distance_query_in_chart(
            make_distance_query(constraint.world, constraint.group, thresholds)
        )

    def within(self, qs: Float64[np.ndarray, "m nv"], influence_distance: float) -> DistanceRows:
        """Return pairs, and nearest pairs, within `influence_distance` [m] of a bound."""
        is_bounded = np.isfinite(self._upper_bound)
        max_distance = (self._upper_bound if is_bounded else self._lower_bound) + influence_distance
        rows = self._distance_query.within(qs, max_distance)
        near_lower = np.flatnonzero(rows.signed_margins - self._lower_bound < influence_distance)
        if not is_bounded:
            return DistanceRows(
                rows.sample_indices[near_lower],
                rows.signed_margins[near_lower] - self._lower_bound,
                rows.gradients[near_lower],
            )
        order = np.lexsort((rows.signed_margins, rows.sample_indices))
        configurations, first = np.unique(rows.sample_indices[order], return_index=True)
        nearest = order[first]
        # Where no pair is within reach there is no gradient; the margin is the worst value known.
        upper_margins = np.full(len(qs), self._upper_bound - max_distance)
        upper_gradients = np.zeros(qs.shape)
        upper_margins[configurations] = self._upper_bound - rows.signed_margins[nearest]
        upper_gradients[configurations] = -rows.gradients[nearest]
        near_upper = np.flatnonzero(upper_margins < influence_distance)
        return DistanceRows(
            np.concatenate([rows.sample_indices[near_lower], near_upper]),
            np.concatenate([
                rows.signed_margins[near_lower] - self._lower_bound,
                upper_margins[near_upper],
            ]),
            np.concatenate([rows.gradients[near_lower], upper_gradients[near_upper]]),
        )
