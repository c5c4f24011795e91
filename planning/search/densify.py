"""More waypoints on the same path."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.search.edges import EdgeChecker

type Array = np.ndarray[Any, np.dtype[np.float64]]


def densified(edges: EdgeChecker, waypoints: Float64[np.ndarray, "n nq"], num_states: int) -> Array:
    """Return at least `num_states` waypoints, the given ones among them, evenly spread.

    Args:
        edges: Knows how waypoints are joined.
        waypoints: Shape (n, nq).
        num_states: How many are wanted.
    """
    lengths = edges.manifold.distance(waypoints[1:], waypoints[:-1])
    if len(waypoints) >= num_states or not lengths.any():
        return waypoints
    counts = np.ceil(lengths * (num_states - 1) / lengths.sum()).astype(int)
    pieces = [
        edges.geodesic(q0, q1, np.arange(count) / count)
        for q0, q1, count in zip(waypoints[:-1], waypoints[1:], counts, strict=True)
        if count
    ]
    dense = np.concatenate([*pieces, waypoints[-1:]])
    # Interpolation may move the corners by a rounding error.
    dense[np.concatenate([[0], np.cumsum(counts)])] = waypoints
    return dense
