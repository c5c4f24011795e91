"""Clique cover of a visibility graph: sets of mutually visible configurations, seeds of regions.

Werner et al. (2024), "Approximating robot configuration spaces with few convex sets using clique
covers of visibility graphs".
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64
from pydrake.planning import MaxCliqueSolverViaGreedy

from planning.domain.arrays import Array, Flags
from planning.regions.free_space import FreeSpace

# Sample spacing of visibility checks [rad or m]: a heuristic, not a proof.
_SAMPLE_SPACING = 0.1


def cliques(space: FreeSpace, qs: Float64[np.ndarray, "k n"]) -> Iterator[Array]:
    """Yield disjoint sets of mutually visible rows, by greedy cliques, about the largest first.

    Drake's solver orders configurations by their degree in the whole graph (decision 39).

    Args:
        space: Checks whether configurations and motions are free.
        qs: Free configurations.
    """
    # 0.3 s, for which a worker's start need not wait.
    from scipy.sparse import csc_matrix  # noqa: PLC0415

    is_visible = _visibility(space, qs)
    remaining, solver = np.arange(len(qs)), MaxCliqueSolverViaGreedy()
    while len(remaining):
        adjacency = csc_matrix(is_visible[np.ix_(remaining, remaining)])
        is_chosen = solver.SolveMaxClique(adjacency)
        yield qs[remaining[is_chosen]]
        remaining = remaining[~is_chosen]


def _visibility(space: FreeSpace, qs: Array) -> Flags:
    first, second = np.triu_indices(len(qs), 1)
    free = space.are_motions_free(qs[first], qs[second] - qs[first], _SAMPLE_SPACING)
    is_visible = np.zeros((len(qs), len(qs)), dtype=bool)
    is_visible[first[free], second[free]] = True
    return is_visible | is_visible.T
