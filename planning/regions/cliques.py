"""Clique cover of a visibility graph: sets of mutually visible configurations, seeds of regions.

Werner et al. (2024), "Approximating robot configuration spaces with few convex sets using clique
covers of visibility graphs".
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Flags
from planning.regions.free_space import FreeSpace

# Sample spacing of visibility checks [rad or m]: a heuristic, not a proof.
_RESOLUTION = 0.1


def cliques(space: FreeSpace, qs: Float64[np.ndarray, "k n"]) -> Iterator[Array]:
    """Yield disjoint sets of mutually visible rows, by greedy cliques, about the largest first.

    Args:
        space: Checks whether configurations and motions are free.
        qs: Free configurations.
    """
    seen = _visibility(space, qs)
    left = np.ones(len(qs), dtype=bool)
    while left.any():
        chosen = _clique(seen & left, left)
        yield qs[chosen]
        left[chosen] = False


def _clique(seen: Flags, left: Flags) -> list[int]:
    """Return a clique of the visibility graph, by greedy choice of the highest remaining degree."""
    candidates, chosen = left.copy(), list[int]()
    while candidates.any():
        degrees = np.where(candidates, (seen & candidates).sum(axis=1), -1)
        best = int(np.argmax(degrees))
        chosen.append(best)
        candidates &= seen[best]
    return chosen


def _visibility(space: FreeSpace, qs: Array) -> Flags:
    first, second = np.triu_indices(len(qs), 1)
    free = space.are_motions_free(qs[first], qs[second] - qs[first], _RESOLUTION)
    seen = np.zeros((len(qs), len(qs)), dtype=bool)
    seen[first[free], second[free]] = True
    return seen | seen.T
