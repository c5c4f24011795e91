"""Clique cover of a visibility graph: sets of mutually visible configurations, seeds of regions.

Werner et al. (2024), "Approximating robot configuration spaces with few convex sets using clique
covers of visibility graphs".
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.planning import MaxCliqueSolverViaGreedy
from scipy.sparse import csc_matrix

from planning.regions.free_space import FreeSpace

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Flags = np.ndarray[Any, np.dtype[np.bool_]]

# Sample spacing of visibility checks [rad or m]: a heuristic, not a proof.
_RESOLUTION = 0.1


def cliques(space: FreeSpace, qs: Float64[np.ndarray, "k n"]) -> Iterator[Array]:
    """Yield disjoint sets of mutually visible rows, by greedy cliques, about the largest first.

    Drake's solver orders configurations by their degree in the whole graph (decision 39).

    Args:
        space: Checks whether configurations and motions are free.
        qs: Free configurations.
    """
    seen = _visibility(space, qs)
    left, solver = np.arange(len(qs)), MaxCliqueSolverViaGreedy()
    while len(left):
        is_chosen = solver.SolveMaxClique(csc_matrix(seen[np.ix_(left, left)]))
        yield qs[left[is_chosen]]
        left = left[~is_chosen]


def _visibility(space: FreeSpace, qs: Array) -> Flags:
    first, second = np.triu_indices(len(qs), 1)
    free = space.are_motions_free(qs[first], qs[second] - qs[first], _RESOLUTION)
    seen = np.zeros((len(qs), len(qs)), dtype=bool)
    seen[first[free], second[free]] = True
    return seen | seen.T
