"""Polyline: waypoints joined by geodesics, addressed by length."""

from typing import Any

import numpy as np
from jaxtyping import Float64, Int64

from planning.search.edges import EdgeChecker

type Array = np.ndarray[Any, np.dtype[np.float64]]


class Polyline:
    """Waypoints with the length from the first one to each.

    Attributes:
        waypoints: Shape (n, nq), n >= 2.
        along: Length from the start to each waypoint, shape (n,).
    """

    def __init__(self, waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker) -> None:
        """Measure the waypoints, shape (n, nq), with the metric of `edges`."""
        self.waypoints = waypoints
        self._edges = edges
        steps = edges.lengths(waypoints[:-1], waypoints[1:])
        self.along: Array = np.append(0.0, np.cumsum(steps))

    @property
    def length(self) -> float:
        """From the first waypoint to the last."""
        return float(self.along[-1])

    def points(
        self, places: Float64[np.ndarray, " m"]
    ) -> tuple[Float64[np.ndarray, "m nq"], Int64[np.ndarray, " m"]]:
        """Return the q at some places, and the edge that each is on or begins.

        At a waypoint's own place that is the waypoint, bit for bit.
        """
        last = len(self.along) - 2
        edge = np.clip(np.searchsorted(self.along, places, side="right") - 1, 0, last)
        begin, end = self.waypoints[edge], self.waypoints[edge + 1]
        lengths = np.maximum(self.along[edge + 1] - self.along[edge], 1e-300)
        fractions = (places - self.along[edge]) / lengths
        qs = self._edges.between(begin, end, fractions)
        for waypoint, is_there in (
            (begin, places == self.along[edge]),
            (end, places == self.along[edge + 1]),
        ):
            qs[is_there] = waypoint[is_there]
        return qs, edge

    def ends(self, edge: Int64[np.ndarray, " m"]) -> Float64[np.ndarray, " m"]:
        """Return where some edges end."""
        return self.along[edge + 1]
