"""Relaxation: waypoints move toward the chords of their neighbours, which shortens the path.

A waypoint v between a and b makes the path |a v| + |v b| - |a b| longer than it need be. Where it
cannot be left out it may still move: as a whole, or in the coordinates of one block only, which
removes useless rotations from a motion whose other coordinates are needed as they are (compare the
partial shortcuts of Geraerts and Overmars, "Creating high-quality paths for motion planning",
2007). In one sweep every block and the whole are tried for every waypoint at once; then all free
moves are made together if the result is free, and else one waypoint at a time. The step length
grows in the next sweep where a move was free and shrinks where it was blocked; moves of too little
gain are not tried any more. So it ends by itself, with as many waypoints as before.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.manifold import Manifold
from planning.search.edges import EdgeChecker
from planning.search.shortcut.polyline import path_measure

_MOST_SWEEPS = 4
# Least gain of a move for which a check is worthwhile, as a share of the length.
_LEAST_GAIN = 3e-3
# Largest share of the way to the chord; 1 would mean to leave the waypoint out.
_FURTHEST_WHOLE = 0.8
_FIRST_WHOLE = 0.5
_FURTHER, _NEARER = 2.0, 0.4


@dataclass(frozen=True)
class _Tries:
    """Candidate moves of one sweep, by waypoint and moved coordinates (the whole, each block).

    Attributes:
        steps: Tangents at the waypoints, shape (m, k, nv).
        qs: Moved waypoints, shape (m, k, nq).
        gains: Decrease of the path's length, shape (m, k).
    """

    steps: Float64[np.ndarray, "m k nv"]
    qs: Float64[np.ndarray, "m k nq"]
    gains: Float64[np.ndarray, "m k"]


def relaxed(
    waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker, is_over: Callable[[], bool]
) -> Array:
    """Return a path that is no longer, of as many waypoints, with the same ends and free edges.

    Args:
        waypoints: From start to goal, shape (n, nq); its edges are free.
        edges: Checker of the new edges.
        is_over: Called before each sweep.
    """
    path = waypoints
    parts = _parts(edges.manifold)
    reach = np.ones((len(path) - 2, len(parts)))
    reach[:, 0] = _FIRST_WHOLE
    for _ in range(_MOST_SWEEPS):
        if len(path) < 3 or is_over():
            break
        tries = _tries(path, reach, parts, edges)
        rows, columns = np.nonzero(tries.gains > _LEAST_GAIN * path_measure(path, edges))
        if not len(rows):
            break
        qs = tries.qs[rows, columns]
        free = _fit(path, rows, qs, edges)
        reach[rows, columns] *= np.where(free, _FURTHER, _NEARER)
        reach = np.minimum(reach, 1.0)
        reach[:, 0] = np.minimum(reach[:, 0], _FURTHEST_WHOLE)
        gains = np.zeros(reach.shape)
        gains[rows[free], columns[free]] = tries.gains[rows[free], columns[free]]
        path = _given_way(path, tries, gains, edges)
    return path


def _parts(manifold: Manifold) -> Array:
    """Return masks of the coordinates that move: all, and each block, shape (k, nv)."""
    rows = [np.ones(manifold.num_velocities)]
    offset = 0
    for joint in manifold.joints:
        for _, block in joint.blocks:
            row = np.zeros(manifold.num_velocities)
            row[[offset + i for i in block]] = 1.0
            rows.append(row)
        offset += joint.num_velocities
    return np.array(rows if len(rows) > 2 else rows[:1])


def _tries(path: Array, reach: Array, parts: Array, edges: EdgeChecker) -> _Tries:
    manifold = edges.manifold
    a, v, b = path[:-2], path[1:-1], path[2:]
    before, after = edges.lengths(a, v), edges.lengths(v, b)
    fractions = before / np.maximum(before + after, 1e-300)
    pull = manifold.minus(edges.between(a, b, fractions), v)
    steps = (reach[:, :, None] * parts) * pull[:, None]
    qs = manifold.plus(v[:, None], steps)
    ways = edges.lengths(a[:, None], qs) + edges.lengths(qs, b[:, None])
    return _Tries(steps, qs, (before + after)[:, None] - ways)


def _fit(path: Array, rows: Any, qs: Array, edges: EdgeChecker) -> Any:
    """Return whether the edges from each q to the neighbours of an inner waypoint are free."""
    free = edges.are_free(np.concatenate([path[rows], qs]), np.concatenate([qs, path[rows + 2]]))
    return free[: len(rows)] & free[len(rows) :]


def _given_way(path: Array, tries: _Tries, gains: Array, edges: EdgeChecker) -> Array:
    """Return the path after the free moves with a gain: all together, or one waypoint at a time."""
    rows = np.flatnonzero(gains.max(axis=1) > 0)
    if not len(rows):
        return path
    steps = np.where(gains[:, :, None] > 0, tries.steps, 0.0)[rows]
    whole, blocks = steps[:, 0], steps[:, 1:].sum(axis=1)
    together = edges.manifold.plus(
        path[rows + 1], np.where(np.abs(whole) > np.abs(blocks), whole, blocks)
    )
    new = path.copy()
    new[rows + 1] = together
    is_changed = np.zeros(len(path) - 1, dtype=bool)
    is_changed[rows] = is_changed[rows + 1] = True
    changed = np.flatnonzero(is_changed)
    is_shorter = path_measure(new, edges) < path_measure(path, edges)
    if is_shorter and edges.are_free(new[changed], new[changed + 1]).all():
        return new
    best = gains[rows].argmax(axis=1)
    return _one_by_one(path, rows, together, tries.qs[rows, best], edges)


def _one_by_one(
    path: Array, rows: Any, together: Array, single: Array, edges: EdgeChecker
) -> Array:
    """Return the path with waypoints moved whose neighbours stay, those of largest gain first."""
    a, b = path[rows], path[rows + 2]
    is_free = _fit(path, rows, together, edges)
    qs = np.where(is_free[:, None], together, single)
    before = edges.lengths(a, path[rows + 1]) + edges.lengths(path[rows + 1], b)
    gains = before - edges.lengths(a, qs) - edges.lengths(qs, b)
    new = path.copy()
    is_taken = np.zeros(len(path) + 1, dtype=bool)
    for k in np.argsort(-gains, kind="stable"):
        here = rows[k] + 1
        if gains[k] > 0 and not is_taken[here - 1 : here + 2].any():
            new[here] = qs[k]
            is_taken[here] = True
    return new
