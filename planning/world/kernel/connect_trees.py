"""ConnectTrees: RRTConnect in the native kernel, between a start and goals."""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array


class ConnectTrees:
    """Two trees of configurations that grow toward each other, with OMPL's steps and numbers."""

    def __init__(self, native_trees: Any, is_edge_free: Callable[[Array, Array], bool]) -> None:
        """Wrap the kernel's trees; `is_edge_free` decides the edges that it is not sure of."""
        self._native = native_trees
        self._is_edge_free = is_edge_free

    @property
    def num_edges_checked(self) -> int:
        """Edges checked so far."""
        return self._native.num_edges_checked

    @property
    def num_states_checked(self) -> int:
        """Samples of these edges so far, both ends of each included."""
        return self._native.num_states_checked

    @property
    def num_vertices(self) -> int:
        """Vertices of both trees."""
        return self._native.num_vertices

    @property
    def num_edges(self) -> int:
        """Edges of both trees."""
        return self._native.num_edges

    @property
    def goal_distance(self) -> float:
        """Least distance to a goal that the start's tree reached; infinite if it reached none."""
        return self._native.goal_distance

    def solve(
        self, report: Callable[[], None], max_states: float, max_samples: float
    ) -> Float64[np.ndarray, "m nq"] | None:
        """Grow the trees until they meet; return the path, or None if a budget ended that.

        Args:
            report: Called once in some 32 edges; ends the search by an exception.
            max_states: States after whose check there are no more samples.
            max_samples: Number of samples that is not reached.
        """
        is_met = self._native.solve(self._is_edge_free, report, max_states, max_samples)
        return self._native.path() if is_met else None
