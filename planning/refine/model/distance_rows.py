"""Rows of a convex program that keep distances at instants of a spline."""

import numpy as np

from planning.domain.arrays import Array, Indices
from planning.refine.constraints.distance_query import DistanceRows
from planning.refine.curves.bspline_basis import BasisWeights
from planning.refine.model.penalty_rows import ProductRows


def reachable_distances(distances: DistanceRows, radii: Array) -> Indices:
    """Return the rows of distances that a step within a box could make too short.

    Args:
        distances: Distances at instants.
        radii: Half of the box's sides around every control point, shape (nq,).
    """
    return np.flatnonzero(
        distances.signed_margins < np.abs(distances.gradients * radii).sum(axis=1)
    )


def distance_rows(
    point_columns: Indices,
    distances: DistanceRows,
    weights: BasisWeights,
    radii: Array,
    penalty: float,
) -> ProductRows:
    """Return the rows of the reachable distances, for control points in units of the box.

    Args:
        point_columns: Columns of the control points, consecutive for each; -1 for those that are
            fixed, shape (k, nq).
        distances: Distances at instants.
        weights: Weights of the control points at these instants.
        radii: Half of the box's sides, shape (nq,).
        penalty: Cost of a metre less than the required distance.
    """
    active = reachable_distances(distances, radii)
    samples, slopes = distances.sample_indices[active], distances.gradients[active] * radii
    return ProductRows(
        point_columns[weights.control_points[samples], 0],
        weights.values[samples],
        slopes,
        -distances.signed_margins[active],
        penalty,
    )
