"""Projection onto the zero set of a constraint residual, and local paths along that set.

Newton's method with the pseudoinverse of the Jacobian, and chains of short projected steps toward a
goal, as in OMPL's projected state spaces (Kingston, Moll, Kavraki, "Exploring implicit spaces for
constrained sampling-based planning", IJRR 38:10, 2019). Roadmaps use this module, since they use
none of OMPL's planners. Only for joints that neither wrap nor float.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.search.edges import EdgeChecker
from planning.search.ompl.projected_space import MOST_ITERATIONS, ON, STEP, Residual

# A projected step longer than this many nominal steps has jumped to another part of the set.
_JUMP = 2.0
# Least progress toward the goal per step, as a share of the step length.
_PROGRESS = 0.1
# How many times a step is halved whose straight edge leaves the set.
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
    """Return waypoints along the set strictly between q0 and q1, shape (k, nq); edges are free.

    None if short steps do not lead from q0 to q1.

    Args:
        residual: Zero on the set.
        edges: Checker of edges; it includes the set as a constraint.
        q0: First configuration, on the set.
        q1: Last configuration, on the set.

    Raises:
        Canceled: The request was canceled.
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
    """Return projected steps from q0 to q1, both included."""
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


def _halved(residual: Residual, way: Array, blocked: Indices) -> Array | None:
    """Return the chain with a projected midpoint added to each blocked step."""
    middles = [projected(residual, (way[i] + way[i + 1]) / 2) for i in blocked]
    found = [q for q in middles if q is not None]
    if len(found) < len(middles):
        return None
    return np.insert(way, blocked + 1, np.stack(found), axis=0)
