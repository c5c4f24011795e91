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
_SAMPLE_SPACING = 0.1


def cliques(space: FreeSpace, qs: Float64[np.ndarray, "k n"]) -> Iterator[Array]:
    """Yield disjoint sets of mutually visible rows, by greedy cliques, about the largest first.

    Args:
        space: Checks whether configurations and motions are free.
        qs: Free configurations.
    """
    is_visible = _visibility(space, qs)
    is_remaining = np.ones(len(qs), dtype=bool)
    while is_remaining.any():
        chosen = _clique(is_visible & is_remaining, is_remaining)
        yield qs[chosen]
        is_remaining[chosen] = False


def _clique(is_visible: Flags, is_remaining: Flags) -> list[int]:
    """Return a clique of the visibility graph, by greedy choice of the highest remaining degree."""
    candidates, chosen = is_remaining.copy(), list[int]()
    while candidates.any():
        degrees = np.where(candidates, (is_visible & candidates).sum(axis=1), -1)
        best = int(np.argmax(degrees))
        chosen.append(best)
        candidates &= is_visible[best]
    return chosen


def _visibility(space: FreeSpace, qs: Array) -> Flags:
    first, second = np.triu_indices(len(qs), 1)
    free = space.are_motions_free(qs[first], qs[second] - qs[first], _SAMPLE_SPACING)
    is_visible = np.zeros((len(qs), len(qs)), dtype=bool)
    is_visible[first[free], second[free]] = True
    return is_visible | is_visible.T
