"""Corner cutting: one waypoint becomes two where that makes a path much shorter."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.motion_samples import steps_of
from planning.search.edges import EdgeChecker
from planning.search.shortcut.polyline import length_by_norm, without_repetitions

# Shares of the edges at a corner that are cut off; an edge has a corner at each end.
_CUT_FRACTIONS = np.array([0.5, 0.25, 0.125])
# Least gain of an additional waypoint, as a share of the length.
_MIN_GAIN = 5e-3


def cut_corners(waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker) -> Array | None:
    """Return a shorter path of free edges, from one of free edges, or None without a gain.

    Args:
        waypoints: From start to goal, shape (n, nq).
        edges: Checker of new edges; an edge is cut only at its checked samples, so that the rest of
            it needs no check (see `polyline.subdivide`).
    """
    if not edges.uses_kernel:
        return cut_corners_in_numpy(waypoints, edges)
    shorter = edges.in_kernel("cut_corners", waypoints, _CUT_FRACTIONS, _MIN_GAIN)
    return shorter if len(shorter) else None


def cut_corners_in_numpy(
    waypoints: Float64[np.ndarray, "n nq"], edges: EdgeChecker
) -> Array | None:
    """Return the same for any joints; what the kernel is compared with."""
    if len(waypoints) < 3:
        return None
    manifold = edges.manifold
    delta = manifold.minus(waypoints[1:], waypoints[:-1])
    steps = steps_of(delta, edges.resolution)
    cut_steps = np.floor(_CUT_FRACTIONS * steps[:, None]).astype(np.int64)
    before = (steps[:-1, None] - cut_steps[:-1]) / steps[:-1, None]
    after = cut_steps[1:] / steps[1:, None]
    p = manifold.plus(waypoints[:-2, None], before[..., None] * delta[:-1, None])
    q = manifold.plus(waypoints[1:-1, None], after[..., None] * delta[1:, None])
    lengths = edges.lengths(waypoints[:-1], waypoints[1:])
    corner_lengths = (1 - before) * lengths[:-1, None] + after * lengths[1:, None]
    cuts = p.reshape(-1, p.shape[2]), q.reshape(-1, p.shape[2])
    gains = corner_lengths - edges.lengths(*cuts).reshape(corner_lengths.shape)
    is_worthwhile = (
        (gains > _MIN_GAIN * length_by_norm(waypoints, edges))
        & (cut_steps[:-1] > 0)
        & (cut_steps[1:] > 0)
    )
    rows, columns = np.nonzero(is_worthwhile)
    if not len(rows):
        return None
    free = edges.are_free(p[rows, columns], q[rows, columns])
    free_gains = np.zeros(gains.shape)
    free_gains[rows[free], columns[free]] = gains[rows[free], columns[free]]
    return _cut(waypoints, p, q, free_gains) if free.any() else None


def _cut(waypoints: Array, p: Array, q: Array, gains: Array) -> Array:
    """Return the path with the cut of largest gain at each corner."""
    pieces = [waypoints[:1]]
    for k, best in enumerate(gains.argmax(axis=1)):
        is_cut = gains[k, best] > 0
        pieces.append(np.stack([p[k, best], q[k, best]]) if is_cut else waypoints[k + 1 : k + 2])
    return without_repetitions(np.concatenate([*pieces, waypoints[-1:]]))
