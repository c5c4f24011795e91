"""Drake's signed distances of shapes, with our own GJK search where Drake fails.

FCL, on which Drake is built, fails on some queries about curved shapes with an exception: of an
ellipsoid and a capsule that touch, a hundred metres large, it finds that a distance that is zero
but for rounding should have been found before (`validateNearestFeatureOfPolytopeBeingEdge`). One
such pair ends the query about all pairs. Then each pair is queried by itself, and those that
fail are searched here.
"""

from typing import Any

import numpy as np
from pydrake.geometry import GeometryId, SignedDistancePair

from planning.domain.arrays import Array
from planning.kernel.gjk import closest_points
from planning.kernel.shape import ConvexShape
from planning.kernel.shape_distance import distance_bounds
from planning.kernel.support import farthest_point
from planning.world.kernel.convex_shapes import convex_shape


def pair_distance(query: Any, a: GeometryId, b: GeometryId) -> SignedDistancePair:
    """Return the signed distance of two shapes, neither a half space, with nearest points.

    Args:
        query: Drake's, at the model's present state.
        a: Shape A.
        b: Shape B.
    """
    try:
        return query.ComputeSignedDistancePairClosestPoints(a, b)
    except RuntimeError:
        return _gjk_distance(query, a, b)


def distances_within(query: Any, max_distance: float) -> list[SignedDistancePair]:
    """Return the same for all unfiltered pairs at most `max_distance` apart [m]."""
    try:
        return list(query.ComputeSignedDistancePairwiseClosestPoints(max_distance))
    except RuntimeError:
        pairs = sorted(query.inspector().GetCollisionCandidates())
        found = [pair_distance(query, a, b) for a, b in pairs]
        return [pair for pair in found if pair.distance <= max_distance]


def _gjk_distance(query: Any, a: GeometryId, b: GeometryId) -> SignedDistancePair:
    inspector = query.inspector()
    first, second = (convex_shape(inspector.GetShape(i)) for i in (a, b))
    assert first is not None and second is not None  # noqa: S101, PT018  (half spaces are ours)
    x_a, x_b = (np.array(query.GetPoseInWorld(i).GetAsMatrix4()) for i in (a, b))
    bounds = distance_bounds((first, second), (x_a, x_b), np.zeros(3))
    witness_points = closest_points(
        lambda n: _support_point(first, x_a, n),
        lambda n: _support_point(second, x_b, n),
        x_a[:3, 3] - x_b[:3, 3],
    )
    p_a, p_b = (
        x[:3, :3].T @ (end - x[:3, 3]) for x, end in zip((x_a, x_b), witness_points, strict=True)
    )
    # For shapes that overlap, the lower bound is minus the translation along its direction that
    # separates them.
    distance = bounds.upper if bounds.upper > 0 else min(bounds.lower, 0.0)
    return SignedDistancePair(
        id_A=a, id_B=b, distance=distance, p_ACa=p_a, p_BCb=p_b, nhat_BA_W=bounds.direction
    )


def _support_point(shape: ConvexShape, x_wg: Array, n: Array) -> Array:
    """Return the point of a shape that lies farthest along n, in world (support function)."""
    return x_wg[:3, 3] + x_wg[:3, :3] @ farthest_point(shape, n @ x_wg[:3, :3])
