"""VariableLayout: indices of the variables of a curve's convex program.

Variables of near instants have near indices, which keeps the solver's Cholesky skyline narrow.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from planning.domain.arrays import Indices
from planning.refine.curves.bspline_basis import greville_abscissae
from planning.refine.curves.path_velocity import path_grid


@dataclass(frozen=True)
class VariableLayout:
    """Indices of variables; -1 for none.

    Attributes:
        control_points: Indices of control points; the first and last have none, shape (k, nq).
        path_velocity: Indices of b at the grid; the first and last have none, shape (n + 1,).
        shortfalls: Indices of the clearance shortfall at every instant, shape (m,).
        num_variables: Number of variables.
    """

    control_points: Indices
    path_velocity: Indices
    shortfalls: Indices
    num_variables: int


@lru_cache(maxsize=8)
def make_variable_layout(
    num_control_points: int, num_coordinates: int, num_shortfalls: int = 0
) -> VariableLayout:
    """Return the layout for numbers of control points, of coordinates and of even instants."""
    num_intervals = len(path_grid(num_control_points).control_points)
    inner = (num_control_points - 2) * num_coordinates
    parameters = np.concatenate([
        np.repeat(greville_abscissae(num_control_points)[1:-1], num_coordinates),
        np.arange(1, num_intervals) / num_intervals,
        np.linspace(0.0, 1.0, num_shortfalls + 2)[1:-1],
    ])
    rank = np.empty(len(parameters), dtype=np.intp)
    rank[np.argsort(parameters, kind="stable")] = np.arange(len(parameters))
    points = np.full((num_control_points, num_coordinates), -1)
    points[1:-1] = rank[:inner].reshape(num_control_points - 2, num_coordinates)
    path_velocity = np.concatenate([[-1], rank[inner : inner + num_intervals - 1], [-1]])
    return VariableLayout(points, path_velocity, rank[inner + num_intervals - 1 :], len(parameters))
