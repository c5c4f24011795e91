"""LocalPlanner: how two states of a roadmap are joined, on every kind of space.

Where joints are free a way is straight. Where a car is among them it is a drive, and near and far
are told by how long drives are. Where constraints leave only a thin set, a straight way leaves it,
and short projected steps follow it.
"""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.search.cars.steering_edges import SteeringEdgeChecker
from planning.search.edges import EdgeChecker
from planning.search.ompl.projected_space import STEP, Residual
from planning.search.projection import way_along

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Rows = np.ndarray[Any, np.dtype[np.intp]]


class LocalPlanner:
    """Looks for free ways."""

    def __init__(self, edges: EdgeChecker, residual: Residual | None = None) -> None:
        """Join by edges, and along the set on which a residual vanishes if there is one."""
        self._edges = edges
        self._residual = residual

    def nearest(
        self, states: Float64[np.ndarray, "m nq"], q: Float64[np.ndarray, " nq"], count: int
    ) -> Rows:
        """Return the rows of states near q, the nearest first, at most so many.

        Along a thin set states are close to one another where ways bend: of those that are within a
        step of another one only that one is told, for where it cannot be reached they hardly can.
        """
        if isinstance(self._edges, SteeringEdgeChecker):
            distances = self._edges.lengths(q[None], states)
        else:
            distances = self._edges.manifold.distance(states, q)
        order = np.argsort(distances, kind="stable")
        if self._residual is None:
            return order[:count]
        apart: list[int] = []
        for row in order.tolist():
            gaps = np.linalg.norm(states[apart] - states[row], axis=1)
            if not (gaps < STEP).any():
                apart.append(row)
            if len(apart) == count:
                break
        return np.array(apart, dtype=np.intp)

    def between(
        self, q0s: Float64[np.ndarray, "m nq"], q1s: Float64[np.ndarray, "m nq"]
    ) -> list[Array | None]:
        """Return for each pair of rows the waypoints between them, shape (k, nq), mostly none.

        None where no free way was found.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        nothing = np.empty((0, q0s.shape[1]))
        return [
            nothing if is_free else self._around(q0, q1)
            for q0, q1, is_free in zip(q0s, q1s, self._edges.are_free(q0s, q1s), strict=True)
        ]

    def _around(self, q0: Array, q1: Array) -> Array | None:
        return None if self._residual is None else way_along(self._residual, self._edges, q0, q1)
