"""Distances that are never larger than the true ones.

Drake's of separate shapes are upper bounds: where a cylinder, a capsule or an ellipsoid is one of
them they were seen to be up to 0.11 mm too large. A slab across the direction in which two shapes
are nearest is a lower bound, and of shapes with corners it is the distance itself. Where it shows
too little of the distance, our own search finds a better one.
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

# A slab that shows all but this share, and this much [m], of a distance is near enough.
_SHARE, _LEAST = 1e-6, 1e-8
# By how much Drake may overstate a distance: this share of it, and as much in metres.
_OVERSTATED = 1e-3


def farther(distance: float) -> float:
    """Return how far Drake must look to meet all that is truly so near [m]."""
    return distance * (1 + _OVERSTATED) + _OVERSTATED


# Reading the hull of a mesh takes milliseconds.
_known: WeakKeyDictionary[RobotDiagram, dict[GeometryId, ConvexShape | None]] = WeakKeyDictionary()


class TrueLengths:
    """Distances of geometries, of a model or shown to a context of it (`NearStanding`)."""

    def __init__(self, model: DrakeModel) -> None:
        """Prepare; shapes of the model are read when they are first needed, and once."""
        self._standing = model.standing
        self._shapes = _known.setdefault(model.diagram, {})

    def of(self, found: Any, query: Any) -> float:
        """Return the signed distance of two geometries, or a little less [m].

        That is how deep they overlap, by Drake, if they do.

        Args:
            found: What Drake says of them: not less than the true distance.
            query: Drake's, with the model where it shall be.
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
        # Of tiny shapes that overlap Drake may not know it.
        return min(shown, length)

    def _shape(self, geometry: GeometryId, query: Any) -> ConvexShape | None:
        row = self._standing.drake_rows.get(geometry)
        if row is not None:
            return self._standing.shapes[row]
        if geometry not in self._shapes:
            self._shapes[geometry] = convex_shape(query.inspector().GetShape(geometry))
        return self._shapes[geometry]
