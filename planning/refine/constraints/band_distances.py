"""Distance band as distances: no pair below the lower bound, the nearest pair within the upper."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.refine.constraints.distance_query import DistanceRows, nearness_of
from planning.refine.curves.chart import Chart
from planning.world.constraints.band_constraint import BandConstraint

# Required distance of pairs outside the band: they never count as near [m].
_NEVER = -1e3


@dataclass(frozen=True)
class BandDemands:
    """Pair thresholds that select a band's pairs and no others.

    Attributes:
        pairs: By full names in sorted order.
    """

    pairs: frozenset[tuple[str, str]]

    @property
    def exceptions(self) -> frozenset[tuple[str, str]]:
        """The band's pairs."""
        return self.pairs

    def demanded(self, body_a: str, body_b: str) -> float:
        """Return the required distance: 0 for the band's pairs, very negative for others [m]."""
        return 0.0 if (min(body_a, body_b), max(body_a, body_b)) in self.pairs else _NEVER


class BandNearness:
    """Signed margins to both bounds of a distance band.

    Every pair has a margin of its own to the lower bound. The upper bound counts for the nearest
    pair only: as long as that pair stays near, the band is kept, wherever the others are.
    """

    def __init__(self, rule: BandConstraint, chart: Chart) -> None:
        """Prepare, with configurations as coordinates of a chart."""
        self._low, self._high = rule.min + rule.room, rule.max - rule.room
        demands = BandDemands(rule.pairs)
        self._measure = chart.measured(nearness_of(rule.world, rule.group, demands))

    def within(self, qs: Float64[np.ndarray, "m nv"], reach: float) -> DistanceRows:
        """Return pairs, and nearest pairs, with a signed margin below `reach` [m] to a bound."""
        is_bounded = np.isfinite(self._high)
        far = (self._high if is_bounded else self._low) + reach
        seen = self._measure.within(qs, far)
        low = np.flatnonzero(seen.spare - self._low < reach)
        if not is_bounded:
            return DistanceRows(seen.at[low], seen.spare[low] - self._low, seen.gradient[low])
        order = np.lexsort((seen.spare, seen.at))
        known, first = np.unique(seen.at[order], return_index=True)
        nearest = order[first]
        # Where no pair is within reach there is no gradient; the margin is the worst value known.
        spare, gradient = np.full(len(qs), self._high - far), np.zeros(qs.shape)
        spare[known] = self._high - seen.spare[nearest]
        gradient[known] = -seen.gradient[nearest]
        high = np.flatnonzero(spare < reach)
        return DistanceRows(
            np.concatenate([seen.at[low], high]),
            np.concatenate([seen.spare[low] - self._low, spare[high]]),
            np.concatenate([seen.gradient[low], gradient[high]]),
        )
