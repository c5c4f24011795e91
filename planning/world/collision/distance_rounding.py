"""True lengths: distances that are never larger than the true ones (lower bounds).

Drake's distances of separate shapes are upper bounds: with a cylinder, a capsule or an ellipsoid
they were measured up to 0.11 mm too large. A slab across the direction in which two shapes
are nearest is a lower bound, and of shapes with corners it is the distance itself. Where it is
much smaller than the distance, our own GJK search finds a better one.
"""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from pydrake.geometry import GeometryId
from pydrake.planning import RobotDiagram

from planning.kernel.shape import ConvexShape
from planning.kernel.shape_distance import distance_bounds, slab
from planning.world.drake_model import DrakeModel
from planning.world.kernel.convex_shapes import convex_shape

# Tolerance of a slab: this share of the distance, and this much [m].
_SHARE, _LEAST = 1e-6, 1e-8
# Largest excess of Drake's distances: this share of the distance, plus as much in metres.
_OVERSTATED = 1e-3


def farther(distance: float) -> float:
    """Return Drake's query distance that finds all pairs truly within `distance` [m]."""
    return distance * (1 + _OVERSTATED) + _OVERSTATED


# Reading the hull of a mesh takes milliseconds.
_known: WeakKeyDictionary[RobotDiagram, dict[GeometryId, ConvexShape | None]] = WeakKeyDictionary()


class TrueLengths:
    """Lower bounds of the distances of geometries, of a model or registered (`NearStatic`)."""

    def __init__(self, model: DrakeModel) -> None:
        """Prepare; each shape of the model is converted at its first use."""
        self._standing = model.standing
        self._shapes = _known.setdefault(model.diagram, {})

    def of(self, found: Any, query: Any) -> float:
        """Return the signed distance of two geometries, or a little less [m].

        For shapes that overlap it is Drake's penetration depth, negative.

        Args:
            found: Drake's result: not less than the true distance.
            query: Drake's, at the model's present state.
        """
        length, ids = float(found.distance), (found.id_A, found.id_B)
        a, b = (self._shape(i, query) for i in ids)
        if length <= 0 or a is None or b is None:
            return length
        first, second = (np.array(query.GetPoseInWorld(i).GetAsMatrix4()) for i in ids)
        shapes, poses, normal = (a, b), (first, second), np.array(found.nhat_BA_W)
        shown = slab(shapes, poses, normal)
        if not shown >= length * (1 - _SHARE) - _LEAST:
            shown = distance_bounds(shapes, poses, normal).lower
        # Drake may miss the overlap of tiny shapes.
        return min(shown, length)

    def _shape(self, geometry: GeometryId, query: Any) -> ConvexShape | None:
        row = self._standing.drake_rows.get(geometry)
        if row is not None:
            return self._standing.shapes[row]
        if geometry not in self._shapes:
            self._shapes[geometry] = convex_shape(query.inspector().GetShape(geometry))
        return self._shapes[geometry]
