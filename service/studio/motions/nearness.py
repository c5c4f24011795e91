"""Nearness: how near anything comes along a motion, and between which points."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from service.studio.numbers import Array


@dataclass(frozen=True)
class NearestPair:
    """The two bodies that are nearest at an instant.

    Attributes:
        bodies: Their names.
        distance: Signed distance [m].
        points: The nearest point of each, in world [m], shape (2, 3).
    """

    bodies: tuple[str, str]
    distance: float
    points: Array


class Nearness:
    """What was measured at some instants of a motion."""

    def __init__(self, times: Array, verdicts: Sequence[Mapping[str, Any]]) -> None:
        """Read verdicts.

        Args:
            times: Of the verdicts [s], shape (n,).
            verdicts: As the API gives them for configurations.
        """
        self.times = times
        self._pairs = [_pair_of(verdict) for verdict in verdicts]

    @property
    def clearance(self) -> Array:
        """Smallest signed distance at each instant [m], shape (n,); infinite without a pair."""
        return np.array([np.inf if pair is None else pair.distance for pair in self._pairs])

    def at(self, time: float) -> NearestPair | None:
        """Return the nearest pair at a time; points move on lines while the pair is the same."""
        row = float(np.interp(time, self.times, np.arange(len(self.times))))
        i = int(row)
        share = row - i
        first, second = self._pairs[i], self._pairs[min(i + 1, len(self._pairs) - 1)]
        if first is None or second is None or first.bodies != second.bodies:
            return first if share < 0.5 else second
        return NearestPair(
            first.bodies,
            (1 - share) * first.distance + share * second.distance,
            (1 - share) * first.points + share * second.points,
        )


def _pair_of(verdict: Mapping[str, Any]) -> NearestPair | None:
    nearest = verdict.get("nearest")
    if nearest is None or len(nearest["points"]) != 2:
        return None
    a, b = nearest["bodies"]
    return NearestPair((a, b), float(nearest["distance"]), np.array(nearest["points"]))
