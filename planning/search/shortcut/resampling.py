"""Resampling: more waypoints on the same path."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.errors import DeadlineExceeded
from planning.search.edges import EdgeChecker
from planning.search.query import Query

# Edges checked between two checks of the time budget.
_BATCH_EDGES = 256


def resample_within_budget(
    query: Query, edges: EdgeChecker, waypoints: Float64[np.ndarray, "n nq"], num_states: int
) -> tuple[Array, bool] | None:
    """Return at least `num_states` waypoints and True, or the given ones and False if time is up.

    None if an edge between the given ones proves to be blocked: cut at other points than its
    checked samples, an edge has other samples.

    Args:
        query: Its options have the time budget.
        edges: Interpolates and checks edges.
        waypoints: Waypoints of a path whose edges are free, shape (n, nq).
        num_states: Requested number of waypoints.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out, and there was no other budget.
    """
    budget = query.options.interpolate_time
    with query.watch.stage("interpolate"):
        if budget is None:
            dense = resample(edges, waypoints, num_states)
            return (dense, True) if edges.are_free(dense[:-1], dense[1:]).all() else None
        resampling_deadline = query.completion_deadline.within(budget)
        try:
            with query.oracle.with_deadline(resampling_deadline):
                resampling_deadline.check("search")
                dense = resample(edges, waypoints, num_states)
                is_free = _are_free(edges, dense)
        except DeadlineExceeded:
            return waypoints, False
    return (dense, True) if is_free else None


def resample(edges: EdgeChecker, waypoints: Float64[np.ndarray, "n nq"], num_states: int) -> Array:
    """Return at least `num_states` waypoints, the given ones among them, evenly spread.

    Args:
        edges: Interpolates edges.
        waypoints: The given waypoints, shape (n, nq).
        num_states: Requested number of waypoints.
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


def _are_free(edges: EdgeChecker, path: Array) -> bool:
    """Return whether all edges are free; all are checked and counted, as without a budget.

    Raises:
        DeadlineExceeded: The time has run out.
    """
    begins = range(0, len(path) - 1, _BATCH_EDGES)
    verdicts = [
        edges.are_free(
            path[i : min(i + _BATCH_EDGES, len(path) - 1)], path[i + 1 : i + 1 + _BATCH_EDGES]
        )
        for i in begins
    ]
    return bool(np.concatenate(verdicts).all())
