"""Relaxation: waypoints move toward the chords of their neighbours, which shortens the path.

A waypoint v between a and b makes the path |a v| + |v b| - |a b| longer than it need be. Where it
cannot be left out it may still move: as a whole, or in the coordinates of one block only, which
removes useless rotations from a motion whose other coordinates are needed as they are (compare the
partial shortcuts of Geraerts and Overmars, "Creating high-quality paths for motion planning",
2007). In one sweep every block and the whole are tried for every waypoint at once; then all free
moves are made together if the result is free, and else one waypoint at a time. The step length
grows in the next sweep where a move was free and shrinks where it was blocked; moves of too little
gain are not tried any more. So it ends by itself, with as many waypoints as before.

The kernel has the same for joints that neither wrap nor float and the Euclidean length; its sums
are in the order of numpy's on x86-64.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.manifold import Manifold
from planning.search.edges import EdgeChecker
from planning.search.shortcut.polyline import length_by_norm

_MAX_SWEEPS = 4
# Least gain of a move for which a check is worthwhile, as a share of the length.
_MIN_GAIN = 3e-3
# Largest share of the way to the chord; 1 would mean to leave the waypoint out.
_MAX_WHOLE_FRACTION = 0.8
_FIRST_WHOLE_FRACTION = 0.5
_STEP_GROWTH, _STEP_SHRINKAGE = 2.0, 0.4


@dataclass(frozen=True)
class _CandidateMoves:
    """Candidate moves of one sweep, by waypoint and moved coordinates (the whole, each block).

    Attributes:
        steps: Tangents at the waypoints, shape (m, k, nv).
        qs: Moved waypoints, shape (m, k, nq).
        gains: Decrease of the path's length, shape (m, k).
    """

    steps: Float64[np.ndarray, "m k nv"]
    qs: Float64[np.ndarray, "m k nq"]
    gains: Float64[np.ndarray, "m k"]


def relax(
    waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker, is_over: Callable[[], bool]
) -> Array:
    """Return a path that is no longer, of as many waypoints, with the same ends and free edges.

    Args:
        waypoints: From start to goal, shape (n, nq); its edges are free.
        edges: Checker of the new edges.
        is_over: Called before each sweep.
    """
    if edges.uses_kernel:
        return edges.in_kernel(
            "relax_path",
            waypoints,
            _MAX_SWEEPS,
            _MIN_GAIN,
            _FIRST_WHOLE_FRACTION,
            _MAX_WHOLE_FRACTION,
            _STEP_GROWTH,
            _STEP_SHRINKAGE,
            is_over,
        )
    return relax_in_numpy(waypoints, edges, is_over)


def relax_in_numpy(
    waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker, is_over: Callable[[], bool]
) -> Array:
    """Return the same for any joints and measures of paths; what the kernel is compared with."""
    path = waypoints
    masks = _coordinate_masks(edges.manifold)
    step_fractions = np.ones((len(path) - 2, len(masks)))
    step_fractions[:, 0] = _FIRST_WHOLE_FRACTION
    for _ in range(_MAX_SWEEPS):
        if len(path) < 3 or is_over():
            break
        moves = _candidate_moves(path, step_fractions, masks, edges)
        rows, columns = np.nonzero(moves.gains > _MIN_GAIN * length_by_norm(path, edges))
        if not len(rows):
            break
        qs = moves.qs[rows, columns]
        free = _are_moves_free(path, rows, qs, edges)
        step_fractions[rows, columns] *= np.where(free, _STEP_GROWTH, _STEP_SHRINKAGE)
        step_fractions = np.minimum(step_fractions, 1.0)
        step_fractions[:, 0] = np.minimum(step_fractions[:, 0], _MAX_WHOLE_FRACTION)
        gains = np.zeros(step_fractions.shape)
        gains[rows[free], columns[free]] = moves.gains[rows[free], columns[free]]
        path = _apply_moves(path, moves, gains, edges)
    return path


def _coordinate_masks(manifold: Manifold) -> Array:
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


def _candidate_moves(
    path: Array, step_fractions: Array, masks: Array, edges: EdgeChecker
) -> _CandidateMoves:
    manifold = edges.manifold
    a, v, b = path[:-2], path[1:-1], path[2:]
    before, after = edges.lengths(a, v), edges.lengths(v, b)
    fractions = before / np.maximum(before + after, 1e-300)
    to_chord = manifold.minus(edges.interpolate_pairs(a, b, fractions), v)
    steps = (step_fractions[:, :, None] * masks) * to_chord[:, None]
    qs = manifold.plus(v[:, None], steps)
    lengths = edges.lengths(a[:, None], qs) + edges.lengths(qs, b[:, None])
    return _CandidateMoves(steps, qs, (before + after)[:, None] - lengths)


def _are_moves_free(path: Array, rows: Any, qs: Array, edges: EdgeChecker) -> Any:
    """Return whether the edges from each q to the neighbours of an inner waypoint are free."""
    free = edges.are_free(np.concatenate([path[rows], qs]), np.concatenate([qs, path[rows + 2]]))
    return free[: len(rows)] & free[len(rows) :]


def _apply_moves(path: Array, moves: _CandidateMoves, gains: Array, edges: EdgeChecker) -> Array:
    """Return the path after the free moves with a gain: all together, or one waypoint at a time."""
    rows = np.flatnonzero(gains.max(axis=1) > 0)
    if not len(rows):
        return path
    steps = np.where(gains[:, :, None] > 0, moves.steps, 0.0)[rows]
    whole, blocks = steps[:, 0], steps[:, 1:].sum(axis=1)
    together = edges.manifold.plus(
        path[rows + 1], np.where(np.abs(whole) > np.abs(blocks), whole, blocks)
    )
    new = path.copy()
    new[rows + 1] = together
    is_changed = np.zeros(len(path) - 1, dtype=bool)
    is_changed[rows] = is_changed[rows + 1] = True
    changed = np.flatnonzero(is_changed)
    is_shorter = length_by_norm(new, edges) < length_by_norm(path, edges)
    if is_shorter and edges.are_free(new[changed], new[changed + 1]).all():
        return new
    best = gains[rows].argmax(axis=1)
    return _apply_one_by_one(path, rows, together, moves.qs[rows, best], edges)


def _apply_one_by_one(
    path: Array, rows: Any, together: Array, single: Array, edges: EdgeChecker
) -> Array:
    """Return the path with waypoints moved whose neighbours stay, those of largest gain first."""
    a, b = path[rows], path[rows + 2]
    is_free = _are_moves_free(path, rows, together, edges)
    qs = np.where(is_free[:, None], together, single)
    before = edges.lengths(a, path[rows + 1]) + edges.lengths(path[rows + 1], b)
    gains = before - edges.lengths(a, qs) - edges.lengths(qs, b)
    new = path.copy()
    is_moved = np.zeros(len(path) + 1, dtype=bool)
    for k in np.argsort(-gains, kind="stable"):
        here = rows[k] + 1
        if gains[k] > 0 and not is_moved[here - 1 : here + 2].any():
            new[here] = qs[k]
            is_moved[here] = True
    return new
