"""Backtracking: a relaxed path moved back toward a free one until a finer check finds it free."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.search.edges import EdgeChecker

_FIRST, _FURTHER = 0.1, 2.0
_LIMIT = 0.75


def backtrack(
    bold: Float64[np.ndarray, "n nq"], sound: Float64[np.ndarray, "n nq"], fine: EdgeChecker
) -> Array:
    """Return a path of free edges, as near to `bold` as a few attempts find one.

    The waypoints at a blocked edge move a tenth of the way back, then a fifth, and so on; all the
    way in the end, where the edges are free.

    Args:
        bold: The desired path, shape (n, nq).
        sound: A path with the same ends and number of waypoints, whose edges are free.
        fine: Checker of edges.
    """
    path = bold.copy()
    back = fine.manifold.minus(sound, bold)
    share = np.zeros(len(path))
    todo = np.flatnonzero((bold != sound).any(axis=1))
    todo = np.unique(np.concatenate([todo - 1, todo]))
    while len(todo):
        blocked = todo[~fine.are_free(path[todo], path[todo + 1])]
        moved = np.unique(np.concatenate([blocked, blocked + 1]))
        moved = moved[share[moved] < 1]
        moved = moved[(moved > 0) & (moved < len(path) - 1)]
        share[moved] = np.where(share[moved] == 0, _FIRST, share[moved] * _FURTHER)
        share[share > _LIMIT] = 1
        path[moved] = fine.manifold.plus(bold[moved], share[moved, None] * back[moved])
        home = share == 1
        path[home] = sound[home]
        todo = np.unique(np.concatenate([moved - 1, moved]))
    return path
