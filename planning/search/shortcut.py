"""Shortcuts: a shorter polyline of geodesics between the same ends, every new edge checked.

OMPL's simplifier may leave the valid set and stops by the clock. This one draws two points of the
path at random, joins them if the geodesic is shorter and free, and drops the waypoints in between
(partial shortcuts; Geraerts and Overmars, "Creating high-quality paths for motion planning", 2007).
"""

from bisect import bisect_right
from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.search.edges import EdgeChecker

type Array = np.ndarray[Any, np.dtype[np.float64]]

_MOST_ROUNDS = 1000
# Draws in a row that gain nothing before we stop.
_PATIENCE = 100
# A draw that would gain less than this share of the length is not worth a check.
_LEAST_GAIN = 1e-3


def shortcut(
    waypoints: Float64[np.ndarray, "n nq"],
    edges: EdgeChecker,
    rng: np.random.Generator,
    is_over: Callable[[], bool],
) -> Array:
    """Return a path that is no longer, with the same ends, shape (m, nq).

    Not promised: that an edge of the given path, or what is left of one, is free; check it again.

    Args:
        waypoints: From start to goal, shape (n, nq).
        edges: Checks what is new.
        rng: Decides what is tried.
        is_over: Asked before each try; an early end leaves a path that is as good as the others.
    """
    line = _Polyline(_without_detours(waypoints, edges, is_over), edges)
    idle = 0
    for _ in range(_MOST_ROUNDS):
        if len(line.waypoints) < 3 or idle >= _PATIENCE or is_over():
            break
        shorter = _joined(line, edges, rng)
        idle = idle + 1 if shorter is None else 0
        line = line if shorter is None else _Polyline(shorter, edges)
    return _without_detours(line.waypoints, edges, is_over)


def path_length(waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker) -> float:
    """Return the sum of the edges' lengths."""
    return float(edges.manifold.distance(waypoints[1:], waypoints[:-1]).sum())


def _without_detours(path: Array, edges: EdgeChecker, is_over: Callable[[], bool]) -> Array:
    """Return the path without the waypoints that can be skipped, from the start on.

    From each waypoint the furthest of the next 1, 2, 4, 8, ... that can be reached is kept.
    """
    kept = [0]
    while kept[-1] < len(path) - 1:
        here = kept[-1]
        reached, stride = here + 1, 2
        while here + stride < len(path) and not is_over():
            if not edges.is_known_free(path[here], path[here + stride]):
                break
            reached, stride = here + stride, stride * 2
        kept.append(reached)
    return path[kept]


class _Polyline:
    """Waypoints with the length from the first one to each."""

    def __init__(self, waypoints: Array, edges: EdgeChecker) -> None:
        self.waypoints = waypoints
        steps = edges.manifold.distance(waypoints[1:], waypoints[:-1])
        self.along: list[float] = [0.0, *np.cumsum(steps).tolist()]

    def edge(self, place: float) -> int:
        """Return the edge at a place, measured by length."""
        return min(max(bisect_right(self.along, place) - 1, 0), len(self.along) - 2)

    def near(self, place: float, edges: EdgeChecker) -> tuple[float, int, Array]:
        """Return a place, its edge and its q; waypoints attract, so that no tiny edges arise."""
        i = self.edge(place)
        for k in (i, i + 1):
            if abs(place - self.along[k]) <= edges.resolution:
                return self.along[k], i, self.waypoints[k]
        fraction = (place - self.along[i]) / (self.along[i + 1] - self.along[i])
        q = edges.geodesic(self.waypoints[i], self.waypoints[i + 1], np.array([fraction]))[0]
        return place, i, q


def _joined(line: _Polyline, edges: EdgeChecker, rng: np.random.Generator) -> Array | None:
    """Return the path with one random shortcut, or None if it gains nothing or is blocked."""
    (s, before, p), (t, after, q) = (line.near(x, edges) for x in sorted(_two_places(line, rng)))
    gain = t - s - edges.distance(p, q)
    if gain <= _LEAST_GAIN * line.along[-1] or not edges.is_known_free(p, q):
        return None
    head, tail = line.waypoints[: before + 1], line.waypoints[after + 1 :]
    joined = np.concatenate([head, p[None], q[None], tail])
    fresh = np.append(True, (joined[1:] != joined[:-1]).any(axis=1))
    return joined[fresh]


def _two_places(line: _Polyline, rng: np.random.Generator) -> tuple[float, float]:
    """Draw two places by length, on two different edges."""
    along = line.along
    first, second = rng.random(2).tolist()
    first *= along[-1]
    edge = line.edge(first)
    skipped = along[edge + 1] - along[edge]
    second *= along[-1] - skipped
    return first, second if second < along[edge] else second + skipped
