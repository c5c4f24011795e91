"""A distance band as distances: no pair nearer than one bound, some pair within the other."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.refine.constraints.distance_query import DistanceRows, nearness_of
from planning.refine.curves.chart import Chart
from planning.world.constraints.band_constraint import BandConstraint

type Array = np.ndarray[Any, np.dtype[np.float64]]

# What is demanded of pairs that do not count: they are never near [m].
_NEVER = -1e3


@dataclass(frozen=True)
class BandDemands:
    """What makes a measure of distances tell those of a band's pairs, and of no others.

    Attributes:
        pairs: By full names in sorted order.
    """

    pairs: frozenset[tuple[str, str]]

    @property
    def exceptions(self) -> frozenset[tuple[str, str]]:
        """The band's pairs."""
        return self.pairs

    def demanded(self, body_a: str, body_b: str) -> float:
        """Return 0 for the band's pairs [m]."""
        return 0.0 if (min(body_a, body_b), max(body_a, body_b)) in self.pairs else _NEVER


class BandNearness:
    """The room to both bounds of a band.

    To the lower one every pair has room of its own. To the upper one the nearest pair has it for
    all: as long as that pair stays near, the band is kept, whatever the others do.
    """

    def __init__(self, rule: BandConstraint, chart: Chart) -> None:
        """Measure in coordinates of a chart."""
        self._low, self._high = rule.min + rule.room, rule.max - rule.room
        demands = BandDemands(rule.pairs)
        self._measure = chart.measured(nearness_of(rule.world, rule.group, demands))

    def within(self, qs: Float64[np.ndarray, "m nv"], reach: float) -> DistanceRows:
        """Return pairs, and the nearest ones, with less than `reach` [m] to a bound."""
        is_bounded = np.isfinite(self._high)
        far = (self._high if is_bounded else self._low) + reach
        seen = self._measure.within(qs, far)
        low = np.flatnonzero(seen.spare - self._low < reach)
        if not is_bounded:
            return DistanceRows(seen.at[low], seen.spare[low] - self._low, seen.gradient[low])
        order = np.lexsort((seen.spare, seen.at))
        known, first = np.unique(seen.at[order], return_index=True)
        nearest = order[first]
        # Where nothing is in sight there is no way to go, but it is as bad as can be told.
        spare, gradient = np.full(len(qs), self._high - far), np.zeros(qs.shape)
        spare[known] = self._high - seen.spare[nearest]
        gradient[known] = -seen.gradient[nearest]
        high = np.flatnonzero(spare < reach)
        return DistanceRows(
            np.concatenate([seen.at[low], high]),
            np.concatenate([seen.spare[low] - self._low, spare[high]]),
            np.concatenate([seen.gradient[low], gradient[high]]),
        )
