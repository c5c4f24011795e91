"""Backtracking: a relaxed path moved back toward a free one until a finer check finds it free."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.search.edges import EdgeChecker

_FIRST_FRACTION, _GROWTH_FACTOR = 0.1, 2.0
_MAX_FRACTION = 0.75


def backtrack(
    desired_path: Float64[np.ndarray, "n nq"],
    free_path: Float64[np.ndarray, "n nq"],
    fine: EdgeChecker,
) -> Array:
    """Return a path of free edges, as near to `desired_path` as a few attempts find one.

    The waypoints at a blocked edge move a tenth of the way back, then a fifth, and so on; all the
    way in the end, where the edges are free.

    Args:
        desired_path: The desired path, shape (n, nq).
        free_path: A path with the same ends and number of waypoints, whose edges are free.
        fine: Checker of edges.
    """
    if fine.uses_kernel:
        return fine.in_kernel(
            "backtrack", desired_path, free_path, _FIRST_FRACTION, _GROWTH_FACTOR, _MAX_FRACTION
        )
    return backtrack_in_numpy(desired_path, free_path, fine)


def backtrack_in_numpy(
    desired_path: Float64[np.ndarray, "n nq"],
    free_path: Float64[np.ndarray, "n nq"],
    fine: EdgeChecker,
) -> Array:
    """Return the same for any joints; what the kernel is compared with."""
    path = desired_path.copy()
    toward_free = fine.manifold.minus(free_path, desired_path)
    fractions = np.zeros(len(path))
    unchecked = np.flatnonzero((desired_path != free_path).any(axis=1))
    unchecked = np.unique(np.concatenate([unchecked - 1, unchecked]))
    while len(unchecked):
        blocked = unchecked[~fine.are_free(path[unchecked], path[unchecked + 1])]
        moved = np.unique(np.concatenate([blocked, blocked + 1]))
        moved = moved[fractions[moved] < 1]
        moved = moved[(moved > 0) & (moved < len(path) - 1)]
        fractions[moved] = np.where(
            fractions[moved] == 0, _FIRST_FRACTION, fractions[moved] * _GROWTH_FACTOR
        )
        fractions[fractions > _MAX_FRACTION] = 1
        path[moved] = fine.manifold.plus(
            desired_path[moved], fractions[moved, None] * toward_free[moved]
        )
        is_restored = fractions == 1
        path[is_restored] = free_path[is_restored]
        unchecked = np.unique(np.concatenate([moved - 1, moved]))
    return path
