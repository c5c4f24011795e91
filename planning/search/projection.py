"""Projection onto the set on which a residual vanishes, and ways along that set.

Newton's method with the pseudoinverse of the Jacobian, and chains of short steps toward a goal,
each of them projected: what OMPL does in its projected state spaces (Kingston, Moll, Kavraki,
"Exploring implicit spaces for constrained sampling-based planning", IJRR 38:10, 2019). Roadmaps do
it here, since they ask none of OMPL's planners. Joints neither wrap nor float.
"""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.search.edges import EdgeChecker
from planning.search.ompl.projected_space import MOST_ITERATIONS, ON, STEP, Residual

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Rows = np.ndarray[Any, np.dtype[np.intp]]

# A projected step that is so many times as long as it should be has jumped elsewhere.
_JUMP = 2.0
# What a step must gain at least, as a share of its length.
_PROGRESS = 0.1
# How often a step whose straight way leaves the set is halved.
_HALVINGS = 2


def projected(residual: Residual, q: Float64[np.ndarray, " nq"]) -> Array | None:
    """Return a configuration near q, shape (nq,), where the residual vanishes, or None."""
    for _ in range(MOST_ITERATIONS):
        miss = residual.residual(q)
        if float(np.linalg.norm(miss)) <= ON:
            return q
        rows = miss != 0
        step, *_ = np.linalg.lstsq(residual.jacobian(q)[rows], miss[rows], rcond=None)
        q = q - step
    return None


def way_along(
    residual: Residual,
    edges: EdgeChecker,
    q0: Float64[np.ndarray, " nq"],
    q1: Float64[np.ndarray, " nq"],
) -> Array | None:
    """Return waypoints between q0 and q1 such that all straight ways are free, shape (k, nq).

    None if no short steps lead there.

    Args:
        residual: Vanishes on the set.
        edges: Says what is free, the set itself considered.
        q0: Where from.
        q1: Where to.

    Raises:
        Canceled: The end was asked for.
        DeadlineExceeded: The time has run out.
    """
    way = _chain(residual, q0, q1)
    for _ in range(_HALVINGS + 1):
        if way is None:
            return None
        free = edges.are_free(way[:-1], way[1:])
        if free.all():
            return way[1:-1]
        way = _halved(residual, way, np.flatnonzero(~free))
    return None


def _chain(residual: Residual, q0: Array, q1: Array) -> Array | None:
    """Return steps from q0 to q1, both included."""
    rows = [q0]
    left = float(np.linalg.norm(q1 - q0))
    while left > STEP:
        here = rows[-1]
        there = projected(residual, here + STEP / left * (q1 - here))
        if there is None or np.linalg.norm(there - here) > _JUMP * STEP:
            return None
        rest = float(np.linalg.norm(q1 - there))
        if rest > left - _PROGRESS * STEP:
            return None
        rows.append(there)
        left = rest
    return np.stack([*rows, q1])


def _halved(residual: Residual, way: Array, blocked: Rows) -> Array | None:
    """Return the way with a step more in the middle of each that is blocked."""
    middles = [projected(residual, (way[i] + way[i + 1]) / 2) for i in blocked]
    found = [q for q in middles if q is not None]
    if len(found) < len(middles):
        return None
    return np.insert(way, blocked + 1, np.stack(found), axis=0)
