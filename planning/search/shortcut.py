"""Shortcuts: a shorter polyline of geodesics between the same ends, every new edge checked.

OMPL's simplifier may leave the valid set and stops by the clock. This one draws two points of the
path at random, joins them if the geodesic is shorter and free, and drops the waypoints in between
(partial shortcuts; Geraerts and Overmars, "Creating high-quality paths for motion planning", 2007).
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.search.edges import EdgeChecker

type Array = np.ndarray[Any, np.dtype[np.float64]]

_MOST_ROUNDS = 300
# Draws in a row that gain nothing before we stop.
_PATIENCE = 60
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
    path = _without_detours(waypoints, edges, is_over)
    idle = 0
    for _ in range(_MOST_ROUNDS):
        if len(path) < 3 or idle >= _PATIENCE or is_over():
            break
        shorter = _joined(path, edges, rng)
        idle = idle + 1 if shorter is None else 0
        path = path if shorter is None else shorter
    return _without_detours(path, edges, is_over)


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


def _joined(path: Array, edges: EdgeChecker, rng: np.random.Generator) -> Array | None:
    """Return the path with one random shortcut, or None if it gains nothing or is blocked."""
    lengths = edges.manifold.distance(path[1:], path[:-1])
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    places = sorted(_two_places(along, rng))
    (s, before, p), (t, after, q) = (_snapped(path, along, x, edges) for x in places)
    gain = t - s - float(edges.manifold.distance(q, p))
    if gain <= _LEAST_GAIN * along[-1] or not edges.is_known_free(p, q):
        return None
    corners = [path[: before + 1], p[None], q[None], path[after + 1 :]]
    joined = np.concatenate(corners)
    fresh = np.append(True, (joined[1:] != joined[:-1]).any(axis=1))
    return joined[fresh]


def _two_places(along: Array, rng: np.random.Generator) -> tuple[float, float]:
    """Draw two places by length, on two different edges."""
    first = float(rng.uniform(0.0, along[-1]))
    edge = _edge(along, first)
    second = float(rng.uniform(0.0, along[-1] - (along[edge + 1] - along[edge])))
    return first, second if second < along[edge] else second + float(along[edge + 1] - along[edge])


def _edge(along: Array, place: float) -> int:
    return int(np.clip(np.searchsorted(along, place, side="right") - 1, 0, len(along) - 2))


def _snapped(
    path: Array, along: Array, place: float, edges: EdgeChecker
) -> tuple[float, int, Array]:
    """Return a place, its edge and its q; waypoints attract, so that no tiny edges arise."""
    i = _edge(along, place)
    for k in (i, i + 1):
        if abs(place - along[k]) <= edges.resolution:
            return float(along[k]), i, path[k]
    fraction = np.array([(place - along[i]) / (along[i + 1] - along[i])])
    return place, i, edges.manifold.interpolate(path[i], path[i + 1], fraction)[0]
