"""DistanceLowerBounds: distances that are never larger than the true ones.

Drake's distances of separate shapes are upper bounds: with a cylinder, a capsule or an ellipsoid
they were measured up to 0.11 mm too large. A slab across the direction in which two shapes are
nearest is a lower bound, and of shapes with corners it is the distance itself. Where it is
much smaller than the distance, our own GJK search finds a better one.
"""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from pydrake.geometry import GeometryId
from pydrake.planning import RobotDiagram

from planning.kernel.shape import ConvexShape
from planning.kernel.shape_distance import distance_bounds, slab_width
from planning.world.drake_model import DrakeModel
from planning.world.kernel.convex_shapes import convex_shape

# Tolerance of a slab: this share of the distance, and this much [m].
_RELATIVE_TOLERANCE, _ABSOLUTE_TOLERANCE = 1e-6, 1e-8
# Largest excess of Drake's distances: this share of the distance, plus as much in metres.
_MAX_OVERSTATEMENT = 1e-3


def inflated_query_distance(distance: float) -> float:
    """Return Drake's query distance that finds all pairs truly within `distance` [m]."""
    return distance * (1 + _MAX_OVERSTATEMENT) + _MAX_OVERSTATEMENT


# Reading the hull of a mesh takes milliseconds.
_shape_cache: WeakKeyDictionary[RobotDiagram, dict[GeometryId, ConvexShape | None]] = (
    WeakKeyDictionary()
)


class DistanceLowerBounds:
    """Lower bounds of the distances of geometries, of a model or registered (`NearStatic`)."""

    def __init__(self, model: DrakeModel) -> None:
        """Prepare; each shape of the model is converted at its first use."""
        self._static_objects = model.static_objects
        self._shapes = _shape_cache.setdefault(model.diagram, {})

    def lower_bound(self, drake_pair: Any, query: Any) -> float:
        """Return the signed distance of two geometries, or a little less [m].

        For shapes that overlap it is Drake's penetration depth, negative.

        Args:
            drake_pair: Drake's result: not less than the true distance.
            query: Drake's, at the model's present state.
        """
        length, ids = float(drake_pair.distance), (drake_pair.id_A, drake_pair.id_B)
        if length <= 0:
            return length
        a, b = (self._shape(i, query) for i in ids)
        if a is None or b is None:
            return length
        first, second = (np.array(query.GetPoseInWorld(i).GetAsMatrix4()) for i in ids)
        shapes, poses, normal = (a, b), (first, second), np.array(drake_pair.nhat_BA_W)
        bound = slab_width(shapes, poses, normal)
        if not bound >= length * (1 - _RELATIVE_TOLERANCE) - _ABSOLUTE_TOLERANCE:
            bound = distance_bounds(shapes, poses, normal).lower
        # Drake may miss the overlap of tiny shapes.
        return min(bound, length)

    def _shape(self, geometry: GeometryId, query: Any) -> ConvexShape | None:
        row = self._static_objects.drake_rows.get(geometry)
        if row is not None:
            return self._static_objects.shapes[row]
        if geometry not in self._shapes:
            self._shapes[geometry] = convex_shape(query.inspector().GetShape(geometry))
        return self._shapes[geometry]
