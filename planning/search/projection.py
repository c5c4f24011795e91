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
from planning.search.ompl.projected_space import MAX_ITERATIONS, SET_STEP, SET_TOLERANCE, Residual

# A projected step longer than this many nominal steps has jumped to another part of the set.
_MAX_STEP_RATIO = 2.0
# Least progress toward the goal per step, as a share of the step length.
_MIN_PROGRESS = 0.1
# How many times a step is halved whose straight edge leaves the set.
_MAX_HALVINGS = 2


def project(residual: Residual, q: Float64[np.ndarray, " nq"]) -> Array | None:
    """Return a configuration near q, shape (nq,), where the residual vanishes, or None."""
    for _ in range(MAX_ITERATIONS):
        value = residual.residual(q)
        if float(np.linalg.norm(value)) <= SET_TOLERANCE:
            return q
        rows = value != 0
        step, *_ = np.linalg.lstsq(residual.jacobian(q)[rows], value[rows], rcond=None)
        q = q - step
    return None


def path_along_set(
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
    chain = _chain(residual, q0, q1)
    for _ in range(_MAX_HALVINGS + 1):
        if chain is None:
            return None
        free = edges.are_free(chain[:-1], chain[1:])
        if free.all():
            return chain[1:-1]
        chain = _refined(residual, chain, np.flatnonzero(~free))
    return None


def _chain(residual: Residual, q0: Array, q1: Array) -> Array | None:
    """Return projected steps from q0 to q1, both included."""
    rows = [q0]
    remaining = float(np.linalg.norm(q1 - q0))
    while remaining > SET_STEP:
        here = rows[-1]
        there = project(residual, here + SET_STEP / remaining * (q1 - here))
        if there is None or np.linalg.norm(there - here) > _MAX_STEP_RATIO * SET_STEP:
            return None
        next_remaining = float(np.linalg.norm(q1 - there))
        if next_remaining > remaining - _MIN_PROGRESS * SET_STEP:
            return None
        rows.append(there)
        remaining = next_remaining
    return np.stack([*rows, q1])


def _refined(residual: Residual, chain: Array, blocked: Indices) -> Array | None:
    """Return the chain with a projected midpoint added to each blocked step."""
    midpoints = [project(residual, (chain[i] + chain[i + 1]) / 2) for i in blocked]
    projected_midpoints = [q for q in midpoints if q is not None]
    if len(projected_midpoints) < len(midpoints):
        return None
    return np.insert(chain, blocked + 1, np.stack(projected_midpoints), axis=0)
