"""Conversion of domain shapes to Drake's shapes."""

import numpy as np
from pydrake import geometry

from planning.domain.geometry.shapes import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    Shape,
    Sphere,
)


def drake_shape(shape: Shape) -> geometry.Shape:  # noqa: C901, PLR0911  (one case per shape)
    """Return Drake's shape; its frame is the object's."""
    match shape:
        case Box():
            return geometry.Box(*shape.size.tolist())
        case Sphere():
            return geometry.Sphere(shape.radius)
        case Cylinder():
            return geometry.Cylinder(shape.radius, shape.length)
        case Capsule():
            return geometry.Capsule(shape.radius, shape.length)
        case Ellipsoid():
            return geometry.Ellipsoid(*shape.semi_axes.tolist())
        case Convex():
            return geometry.Convex(np.asfortranarray(np.asarray(shape.points).T), "convex")
        case Mesh():
            return geometry.Mesh(shape.uri, scale3=np.asarray(shape.scale))
        case HalfSpace():
            return geometry.HalfSpace()
