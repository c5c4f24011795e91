"""Polyline: waypoints joined by geodesics; lengths, subdivision and unwrapping."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from planning.domain.arrays import Array
from planning.domain.curves.motion_samples import steps_of
from planning.domain.robot.manifold import Manifold
from planning.search.edges import EdgeChecker


def length_by_norm(waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker) -> float:
    """Return the sum of the edges' lengths by the checker's norm."""
    return float(edges.lengths(waypoints[:-1], waypoints[1:]).sum())


def path_length(waypoints: Float64[np.ndarray, "n nq"], manifold: Manifold) -> float:
    """Return the sum of the edges' lengths (radians and metres weigh the same)."""
    delta = manifold.minus(waypoints[1:], waypoints[:-1])
    return float(np.sqrt(np.einsum("...v,...v->...", delta, delta)).sum())


def without_repetitions(waypoints: Float64[np.ndarray, "n nq"]) -> Array:
    """Return the path without waypoints that repeat the one before."""
    return waypoints[np.append(True, (waypoints[1:] != waypoints[:-1]).any(axis=1))]


def unwrap(waypoints: Float64[np.ndarray, "n nq"], manifold: Manifold) -> Array:
    """Return the path without jumps by full turns and without sign changes of a quaternion.

    The ends stay as they are: the last one may differ by full turns from the waypoint before it.
    """
    path = waypoints.copy()
    if not manifold.is_vector_space:
        for i in range(1, len(path) - 1):
            path[i] = manifold.plus(path[i - 1], manifold.minus(path[i], path[i - 1]))
    return path


@dataclass(frozen=True)
class PolylinePoints:
    """Points on a polyline, in order, its waypoints among them.

    Attributes:
        qs: Shape (m, nq).
        first_edge: The first edge that each lies on, shape (m,).
        last_edge: The last one: the next edge for a waypoint, the same for a point between two.
    """

    qs: Float64[np.ndarray, "m nq"]
    first_edge: Int64[np.ndarray, " m"]
    last_edge: Int64[np.ndarray, " m"]

    @property
    def in_reverse(self) -> "PolylinePoints":
        """The same points in reverse order."""
        return PolylinePoints(self.qs[::-1], -self.last_edge[::-1], -self.first_edge[::-1])

    def last_on_edge_of(self, i: int) -> int:
        """Return the last point that lies on one edge with point i."""
        # Edges are in order, so are the points.
        return int(np.searchsorted(self.first_edge, self.last_edge[i], side="right")) - 1


def subdivide(
    waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker, max_parts: int
) -> PolylinePoints:
    """Return the waypoints, and points that cut every edge into about equal pieces.

    Edges are cut at their checked samples: each piece of a free edge consists of the same samples,
    so it is free as well (n steps of an edge are the least number that is short enough; then so are
    k steps for every k of them, but for rounding).
    """
    delta = edges.manifold.minus(waypoints[1:], waypoints[:-1])
    steps = steps_of(delta, edges.resolution)
    parts = np.minimum(max_parts, steps)
    edge = np.repeat(np.arange(len(delta)), parts)
    part = np.arange(len(edge)) - np.repeat(np.cumsum(parts) - parts, parts)
    sample = part * steps[edge] // parts[edge]
    qs = edges.manifold.plus(waypoints[edge], (sample / steps[edge])[:, None] * delta[edge])
    is_corner = sample == 0
    qs[is_corner] = waypoints[:-1]
    return PolylinePoints(
        np.concatenate([qs, waypoints[-1:]]),
        np.append(edge - is_corner, len(delta) - 1),
        np.append(edge, len(delta)),
    )
