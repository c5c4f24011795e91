"""Shortcuts: a shorter polyline of geodesics between the same ends, every new edge checked.

OMPL's simplifier may leave the valid set and stops by the clock. This one draws two points of the
path at random and tries to make the way between them straight: in all coordinates, or in those of
one block only, which takes useless turns out of a motion whose other coordinates are needed as they
are (partial shortcuts; Geraerts and Overmars, "Creating high-quality paths for motion planning",
2007).
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.joints import Joint, JointType
from planning.search.edges import EdgeChecker
from planning.search.polyline import Polyline

type Array = np.ndarray[Any, np.dtype[np.float64]]

_MOST_ROUNDS = 1000
# Draws in a row that gain nothing before we stop.
_PATIENCE = 60
# A draw that would gain less than this share of the length is not worth a check.
_LEAST_GAIN = 1e-3

_PLANAR = ((0, 1), (2,))
_FLOATING = ((0, 1, 2, 3), (4, 5, 6))


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
    blocks = position_blocks(edges.manifold.joints)
    line = Polyline(_without_detours(waypoints, edges, is_over), edges)
    idle = 0
    for _ in range(_MOST_ROUNDS):
        if len(line.waypoints) < 3 or idle >= _PATIENCE or is_over():
            break
        shorter = _straightened(line, blocks, edges, rng)
        idle = idle + 1 if shorter is None else 0
        line = line if shorter is None else Polyline(shorter, edges)
    return _without_detours(line.waypoints, edges, is_over)


def path_length(waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker) -> float:
    """Return the sum of the edges' lengths."""
    return float(edges.manifold.distance(waypoints[1:], waypoints[:-1]).sum())


def position_blocks(joints: tuple[Joint, ...]) -> list[list[int]]:
    """Return the sets of coordinates of q that can be straightened by themselves."""
    found: list[list[int]] = []
    iq = 0
    for joint in joints:
        match joint.type:
            case JointType.PLANAR:
                parts = _PLANAR
            case JointType.FLOATING:
                parts = _FLOATING
            case _:
                parts = ((0,),)
        found += [[iq + k for k in part] for part in parts]
        iq += len(joint.position_names)
    return found


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


def _straightened(
    line: Polyline, blocks: list[list[int]], edges: EdgeChecker, rng: np.random.Generator
) -> Array | None:
    """Return the path with one random shortcut, or None if it gains nothing or is blocked."""
    (s, before, p), (t, after, q) = (line.near(place) for place in line.two_places(rng))
    if t <= s:
        return None
    new = np.stack([p, q])
    choice = int(rng.integers(4 * len(blocks)))
    if choice < len(blocks) and len(blocks) > 1:
        fractions = (np.array([s, *line.along[before + 1 : after + 1], t]) - s) / (t - s)
        straight = edges.geodesic(p, q, np.clip(fractions, 0.0, 1.0))
        new = np.concatenate([p[None], line.waypoints[before + 1 : after + 1], q[None]])
        new[1:-1, blocks[choice]] = straight[1:-1, blocks[choice]]
    gain = t - s - path_length(new, edges)
    if gain <= _LEAST_GAIN * line.length:
        return None
    new = _distinct(new)
    if not all(edges.is_known_free(a, b) for a, b in pairwise(new)):
        return None
    head, tail = line.waypoints[: before + 1], line.waypoints[after + 1 :]
    return _distinct(np.concatenate([head, new, tail]))


def _distinct(path: Array) -> Array:
    """Return the path without waypoints that repeat the one before."""
    return path[np.append(True, (path[1:] != path[:-1]).any(axis=1))]
