"""EdgeChecker: validity of an edge (a geodesic between two configurations) by sampling."""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.domain.robot.manifold import Manifold
from planning.kernel.native import native
from planning.search.collision_oracle import WatchedOracle


class EdgeChecker:
    """Checker of edges by samples at most one resolution apart, against a collision oracle.

    Not promised: anything between two samples.

    Attributes:
        norm: Measure of tangents, by which the gain of a shortcut is computed.
        is_euclidean: Whether that is the length of the difference of two configurations.
        resolution: Largest distance between two samples (radians and metres weigh the same).
        num_motions: Edges checked so far.
    """

    def __init__(
        self,
        manifold: Manifold,
        oracle: WatchedOracle,
        resolution: float,
        norm: Callable[[Array], Array] | None = None,
    ) -> None:
        """Make a checker with its counter at zero; `norm` is the Euclidean length by default."""
        self.norm = norm or _euclidean
        self.is_euclidean = norm is None and manifold.is_vector_space
        self.manifold = manifold
        self.resolution = resolution
        self.num_motions = 0
        self._oracle = oracle
        self._is_vector = manifold.is_vector_space

    def is_free(self, q0: Float64[np.ndarray, " nq"], q1: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether all samples of the geodesic are free, q1's included, q0's not.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        self.num_motions += 1
        return self._oracle.is_motion_free(q0, self.manifold.minus(q1, q0), self.resolution)

    def is_whole_edge_free(self, q0: list[float], q1: list[float]) -> bool:
        """Return whether all samples of the geodesic are free, both ends included.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        self.num_motions += 1
        if self._is_vector:
            return self._oracle.is_edge_free(q0, q1, self.resolution)
        begin, end = np.array(q0), np.array(q1)
        return self._oracle.is_free(begin) and self._oracle.is_motion_free(
            begin, self.manifold.minus(end, begin), self.resolution
        )

    def are_free(
        self, q0s: Float64[np.ndarray, "m nq"], q1s: Float64[np.ndarray, "m nq"]
    ) -> Bool[np.ndarray, " m"]:
        """Return whether each edge is free as by `is_free`, for pairs of rows.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        self.num_motions += len(q0s)
        if self._is_vector:
            return self._oracle.are_edges_free(q0s, q1s, self.resolution)
        delta = self.manifold.minus(q1s, q0s)
        return self._oracle.are_motions_free(q0s, delta, self.resolution)

    def first_free(
        self, q0s: Float64[np.ndarray, "#m nq"], q1s: Float64[np.ndarray, "#m nq"]
    ) -> int:
        """Return the index of the first edge that is free as by `is_free`; their number if none is.

        Args:
            q0s: Where edges begin, one row for each or for all.
            q1s: Where they end, likewise.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        count = len(q1s) if len(q0s) == 1 else len(q0s)
        if self._is_vector:
            index = self._oracle.first_free_edge(q0s, q1s, self.resolution)
            self.num_motions += min(index + 1, count)
            return index
        pairs = zip(*np.broadcast_arrays(q0s, q1s), strict=True)
        return next((i for i, (q0, q1) in enumerate(pairs) if self.is_free(q0, q1)), count)

    @property
    def uses_kernel(self) -> bool:
        """Whether `in_kernel` may be called: for joints that neither wrap nor float."""
        return self.is_euclidean and native() is not None

    def in_kernel(self, function: str, *arguments: Any) -> Array:
        """Return what a function of the kernel makes of a path by these edges, shape (m, nq).

        The kernel asks its own checker, if the oracle has one, and this checker where that is not
        sure; the counters go on.

        Args:
            function: Its name.
            arguments: Those after the edges.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        module: Any = native()
        oracle = self._oracle
        edges = module.CheckedEdges(
            oracle.native_checker,
            self.manifold.num_positions,
            self.resolution,
            oracle.check_deadline,
            self.are_free,
            self.first_free,
        )
        try:
            return getattr(module, function)(edges, *arguments)
        finally:
            self.num_motions += edges.num_edges
            oracle.num_states += edges.num_states

    def lengths(
        self, q0s: Float64[np.ndarray, "*#m nq"], q1s: Float64[np.ndarray, "*#m nq"]
    ) -> Float64[np.ndarray, "*m"]:
        """Return the lengths by `norm` of the geodesics between rows."""
        return self.norm(self.manifold.minus(q1s, q0s))

    def interpolate_pairs(
        self,
        q0s: Float64[np.ndarray, "m nq"],
        q1s: Float64[np.ndarray, "m nq"],
        fractions: Float64[np.ndarray, " m"],
    ) -> Array:
        """Return the configuration at a fraction of the geodesic between each pair of rows."""
        return self.manifold.plus(q0s, fractions[:, None] * self.manifold.minus(q1s, q0s))

    def local_path(self, q0: Float64[np.ndarray, " nq"], q1: Float64[np.ndarray, " nq"]) -> Array:
        """Return waypoints from q0 to q1, joined by geodesics, shape (k, nq): here q0 and q1."""
        return np.stack([q0, q1])

    def geodesic(
        self,
        q0: Float64[np.ndarray, " nq"],
        q1: Float64[np.ndarray, " nq"],
        fractions: Float64[np.ndarray, " m"],
    ) -> Array:
        """Return the configurations at fractions of the geodesic from q0 to q1, shape (m, nq)."""
        return self.manifold.plus(q0, fractions[:, None] * self.manifold.minus(q1, q0))


def _euclidean(delta: Array) -> Array:
    return np.sqrt(np.einsum("...v,...v->...", delta, delta))
