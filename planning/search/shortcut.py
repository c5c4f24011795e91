"""Shortcuts: a shorter polyline of geodesics between the same ends, every new edge checked.

OMPL's simplifier may leave the valid set and stops by the clock. This one puts points on the path,
asks at once which pairs of them see each other, and takes the shortest way through all of them, by
dynamic programming: a round does what dozens of random shortcuts do one by one. Rounds with fresh
points follow until they gain little. Between them the coordinates of one block are straightened
alone, which takes useless turns out of a motion whose other coordinates are needed as they are
(partial shortcuts; Geraerts and Overmars, "Creating high-quality paths for motion planning", 2007).
"""

from collections.abc import Callable
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.joints import Joint, JointType
from planning.search.edges import EdgeChecker
from planning.search.polyline import Polyline

type Array = np.ndarray[Any, np.dtype[np.float64]]

_MOST_ROUNDS = 8
# Rounds in a row that gain less than this share of the length before we stop.
_PATIENCE = 1
_LEAST_GAIN = 0.01
# Points on the path in one round, its corners included where they are not too many.
_POINTS = 14
# Pairs of points are looked at so many times less closely before they are taken for neighbours; the
# way that is taken is then looked at in full, and anew where that finds a collision.
_ROUGH = 4.0
_MOST_CORNERS = 28
# What a corner costs as length: of two ways that are nearly as short the one with fewer is quicker.
_CORNER = 0.02
# Partial shortcuts that are checked in one round, the most promising of all.
_PARTIAL = 24

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
        rng: Decides where points are put.
        is_over: Asked before each round; an early end leaves a path that is as good as the others.
    """
    path = waypoints
    blocks = position_blocks(edges.manifold.joints)
    idle = 0
    for round_ in range(_MOST_ROUNDS):
        if len(path) < 3 or idle >= _PATIENCE or is_over():
            break
        line = Polyline(path, edges)
        shorter = _shortest_way(_places(line, round_, rng), line, edges)
        if len(blocks) > 1 and len(shorter) > 2:
            shorter = _with_straight_blocks(shorter, blocks, edges)
        length = path_length(shorter, edges)
        idle = 0 if length < line.length * (1 - _LEAST_GAIN) else idle + 1
        if length <= line.length:
            path = shorter
    return path


def path_length(waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker) -> float:
    """Return the sum of the edges' lengths."""
    return float(edges.lengths(waypoints[:-1], waypoints[1:]).sum())


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


def _places(line: Polyline, round_: int, rng: np.random.Generator) -> Array:
    """Return where points are put, as lengths along the path, in order; both ends are among them."""
    corners = np.array(line.along)
    if len(corners) > _MOST_CORNERS:
        corners = corners[np.unique(np.linspace(0, len(corners) - 1, _MOST_CORNERS).astype(int))]
    if round_ == 0:
        return corners
    count = max(_POINTS - len(corners), 4)
    spread = (np.arange(count) + rng.random(count)) * (line.length / count)
    return np.unique(np.concatenate([corners, spread]))


def _shortest_way(places: Array, line: Polyline, edges: EdgeChecker) -> Array:
    """Return the shortest way from point to point, of all that see each other."""
    points, owners = line.points(places)
    first, second = np.triu_indices(len(places), 1)
    chords = edges.lengths(points[first], points[second])
    # On one edge of the path, or where nothing is gained, the path itself is as good.
    same_edge = places[second] <= line.ends(owners[first])
    gains = places[second] - places[first] - chords > 1e-9 + 1e-3 * chords
    asked = np.flatnonzero(gains & ~same_edge)
    cost = np.full(len(first), np.inf)
    cost[same_edge] = chords[same_edge] + _CORNER
    hopeful = asked[edges.are_free(points[first[asked]], points[second[asked]], _ROUGH)]
    cost[hopeful] = chords[hopeful] + _CORNER
    known = same_edge
    count = len(places)
    while True:
        chain = _cheapest(count, first, second, cost)
        used = np.array([_row_of_pair(i, j, count) for i, j in pairwise(chain)])
        new = used[~known[used]]
        free = edges.are_free(points[first[new]], points[second[new]])
        known[new[free]] = True
        cost[new[~free]] = np.inf
        if free.all():
            return points[chain]


def _row_of_pair(i: int, j: int, count: int) -> int:
    """Return the row of a pair i < j among all pairs, as np.triu_indices counts them."""
    return i * count - i * (i + 1) // 2 + j - i - 1


def _cheapest(count: int, first: Any, second: Any, cost: Array) -> list[int]:
    """Return the cheapest chain of points from 0 to count - 1; edges lead forwards."""
    table = np.full((count, count), np.inf)
    table[first, second] = cost
    best = np.zeros(count)
    came = np.zeros(count, dtype=np.intp)
    for j in range(1, count):
        totals = best[:j] + table[:j, j]
        came[j] = i = int(np.argmin(totals))
        best[j] = totals[i]
    chain = [count - 1]
    while chain[-1]:
        chain.append(int(came[chain[-1]]))
    return chain[::-1]


def _with_straight_blocks(path: Array, blocks: list[list[int]], edges: EdgeChecker) -> Array:
    """Return the path with one block straightened between two of its corners, where that pays."""
    steps = edges.lengths(path[:-1], path[1:])
    tries = np.concatenate([
        _with_straight_block(path, steps, span, blocks, edges)
        for span in combinations(range(len(path)), 2)
        if span[1] > span[0] + 1
    ])
    num_edges, nq = len(path) - 1, path.shape[1]
    lengths = edges.lengths(tries[:, :-1].reshape(-1, nq), tries[:, 1:].reshape(-1, nq))
    gains = steps.sum() - lengths.reshape(-1, num_edges).sum(axis=1)
    order = np.argsort(-gains, kind="stable")[:_PARTIAL]
    order = order[gains[order] > _LEAST_GAIN * steps.sum()]
    for some in (order[:2], order[2:]):
        begins, ends = tries[some, :-1].reshape(-1, nq), tries[some, 1:].reshape(-1, nq)
        free = edges.are_free(begins, ends).reshape(-1, num_edges).all(axis=1)
        if free.any():
            return tries[some[int(np.argmax(free))]]
    return path


def _with_straight_block(
    path: Array, steps: Array, span: tuple[int, int], blocks: list[list[int]], edges: EdgeChecker
) -> Array:
    """Return the path with each block straightened within a span, shape (num_blocks, n, nq)."""
    begin, end = span
    along = np.cumsum(steps[begin:end])
    straight = edges.geodesic(path[begin], path[end], along[:-1] / max(along[-1], 1e-300))
    tries = np.repeat(path[None], len(blocks), axis=0)
    for new, block in zip(tries, blocks, strict=True):
        new[begin + 1 : end, block] = straight[:, block]
    return tries
