"""VariableLayout: indices of the variables of a curve's convex program.

Variables of near instants have near indices, which keeps the solver's Cholesky skyline narrow.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from planning.domain.arrays import Indices
from planning.refine.curves.bspline_basis import centres
from planning.refine.curves.path_velocity import grid_of


@dataclass(frozen=True)
class VariableLayout:
    """Indices of variables; -1 for none.

    Attributes:
        points: Of control points, where the first and last have none, shape (k, nq).
        pace: Of b at the grid, where the first and last have none, shape (n + 1,).
        lacks: Of the clearance objective's shortfall at every instant, shape (m,).
        count: Number of variables.
    """

    points: Indices
    pace: Indices
    lacks: Indices
    count: int


@lru_cache(maxsize=8)
def numbering_of(count: int, num_coordinates: int, num_lacks: int = 0) -> VariableLayout:
    """Return the layout for numbers of control points, of coordinates and of even instants."""
    n = len(grid_of(count).owners)
    inner = (count - 2) * num_coordinates
    at = np.concatenate([
        np.repeat(centres(count)[1:-1], num_coordinates),
        np.arange(1, n) / n,
        np.linspace(0.0, 1.0, num_lacks + 2)[1:-1],
    ])
    rank = np.empty(len(at), dtype=np.intp)
    rank[np.argsort(at, kind="stable")] = np.arange(len(at))
    points = np.full((count, num_coordinates), -1)
    points[1:-1] = rank[:inner].reshape(count - 2, num_coordinates)
    pace = np.concatenate([[-1], rank[inner : inner + n - 1], [-1]])
    return VariableLayout(points, pace, rank[inner + n - 1 :], len(at))
