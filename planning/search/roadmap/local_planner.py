"""LocalPlanner: the connection of two states of a roadmap, on every kind of space.

For free joints it is a straight edge. For a group with a car it is a steering path, and neighbours
are near by the length of such paths. Under constraints that leave only a thin set it is a chain of
short projected steps along that set, where the straight edge leaves it.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.search.cars.steering_edges import SteeringEdgeChecker
from planning.search.edges import EdgeChecker
from planning.search.ompl.projected_space import SET_STEP, Residual
from planning.search.projection import path_along_set


class LocalPlanner:
    """Local planner of a roadmap: neighbours of a state and free connections to them."""

    def __init__(self, edges: EdgeChecker, residual: Residual | None = None) -> None:
        """Connect by edges, and along the zero set of a residual if there is one."""
        self._edges = edges
        self._residual = residual

    def nearest(
        self, states: Float64[np.ndarray, "m nq"], q: Float64[np.ndarray, " nq"], count: int
    ) -> Indices:
        """Return the rows of the `count` states nearest to q, the nearest first.

        Along a thin set the states of a bent edge are close to one another: of states within one
        step of each other only the nearest is returned, for if it cannot be reached, the others
        hardly can.
        """
        if isinstance(self._edges, SteeringEdgeChecker):
            distances = self._edges.lengths(q[None], states)
        else:
            distances = self._edges.manifold.distance(states, q)
        order = np.argsort(distances, kind="stable")
        if self._residual is None:
            return order[:count]
        spread_rows: list[int] = []
        for row in order.tolist():
            gaps = np.linalg.norm(states[spread_rows] - states[row], axis=1)
            if not (gaps < SET_STEP).any():
                spread_rows.append(row)
            if len(spread_rows) == count:
                break
        return np.array(spread_rows, dtype=np.intp)

    def connections(
        self, q0s: Float64[np.ndarray, "m nq"], q1s: Float64[np.ndarray, "m nq"]
    ) -> list[Array | None]:
        """Return for each pair of rows the waypoints strictly between, shape (k, nq), mostly k = 0.

        None where no free connection was found.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        no_waypoints = np.empty((0, q0s.shape[1]))
        return [
            no_waypoints if is_free else self._path_along_set(q0, q1)
            for q0, q1, is_free in zip(q0s, q1s, self._edges.are_free(q0s, q1s), strict=True)
        ]

    def _path_along_set(self, q0: Array, q1: Array) -> Array | None:
        return (
            None if self._residual is None else path_along_set(self._residual, self._edges, q0, q1)
        )
