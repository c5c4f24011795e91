"""VariableLayout: which variable of a convex program stands for what.

What belongs to near instants has near numbers, which the solver likes.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from planning.refine.curves.bspline_basis import centres
from planning.refine.curves.path_velocity import grid_of

type Indices = np.ndarray[Any, np.dtype[np.intp]]


@dataclass(frozen=True)
class VariableLayout:
    """Variables, where -1 is none.

    Attributes:
        points: Of control points, of which the first and last are none, shape (k, nq).
        pace: Of b at the grid, of which the first and last are none, shape (n + 1,).
        lacks: Of what is lacking of a wish at every instant, shape (m,).
        count: Of all.
    """

    points: Indices
    pace: Indices
    lacks: Indices
    count: int


@lru_cache(maxsize=8)
def numbering_of(count: int, num_coordinates: int, num_lacks: int = 0) -> VariableLayout:
    """Return the numbering for a number of control points, of coordinates, of even instants."""
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
