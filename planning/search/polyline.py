"""Polyline: waypoints joined by geodesics, addressed by length."""

from bisect import bisect_right
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.search.edges import EdgeChecker

type Array = np.ndarray[Any, np.dtype[np.float64]]


class Polyline:
    """Waypoints with the length from the first one to each.

    Attributes:
        waypoints: Shape (n, nq), n >= 2.
        along: Length from the start to each waypoint.
    """

    def __init__(self, waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker) -> None:
        """Measure the waypoints, shape (n, nq), with the metric of `edges`."""
        self.waypoints = waypoints
        self._edges = edges
        steps = edges.manifold.distance(waypoints[1:], waypoints[:-1])
        self.along: list[float] = [0.0, *np.cumsum(steps).tolist()]

    @property
    def length(self) -> float:
        """From the first waypoint to the last."""
        return self.along[-1]

    def edge(self, place: float) -> int:
        """Return the edge at a place."""
        return min(max(bisect_right(self.along, place) - 1, 0), len(self.along) - 2)

    def near(self, place: float) -> tuple[float, int, Array]:
        """Return a place, its edge and its q; waypoints attract, so that no tiny edges arise."""
        i = self.edge(place)
        for k in (i, i + 1):
            if abs(place - self.along[k]) <= self._edges.resolution:
                return self.along[k], i, self.waypoints[k]
        fraction = np.array([(place - self.along[i]) / (self.along[i + 1] - self.along[i])])
        q = self._edges.geodesic(self.waypoints[i], self.waypoints[i + 1], fraction)[0]
        return place, i, q

    def two_places(self, rng: np.random.Generator) -> tuple[float, float]:
        """Draw two places by length, in order, on two different edges."""
        first, second = rng.random(2).tolist()
        first *= self.length
        edge = self.edge(first)
        skipped = self.along[edge + 1] - self.along[edge]
        second *= self.length - skipped
        if second >= self.along[edge]:
            second += skipped
        return min(first, second), max(first, second)
