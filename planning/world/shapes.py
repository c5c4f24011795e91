"""Give our shapes to Drake."""

import numpy as np
from pydrake import geometry
from pydrake.math import RigidTransform

from planning.domain.shapes import (
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

# Drake measures no distance between a half space and most shapes; a box this large, with its top
# where the half space ends, is measured against everything.
_HALF_SPACE_WIDTH = 200.0
_HALF_SPACE_DEPTH = 20.0


def drake_shape(shape: Shape) -> tuple[geometry.Shape, RigidTransform]:  # noqa: C901, PLR0911  (one case per shape)
    """Return Drake's shape G of the object O, and X_OG."""
    identity = RigidTransform()
    match shape:
        case Box():
            return geometry.Box(*shape.size), identity
        case Sphere():
            return geometry.Sphere(shape.radius), identity
        case Cylinder():
            return geometry.Cylinder(shape.radius, shape.length), identity
        case Capsule():
            return geometry.Capsule(shape.radius, shape.length), identity
        case Ellipsoid():
            return geometry.Ellipsoid(*shape.semi_axes), identity
        case Convex():
            return geometry.Convex(
                np.asfortranarray(np.asarray(shape.points).T), "convex"
            ), identity
        case Mesh():
            return geometry.Mesh(shape.uri, scale3=np.asarray(shape.scale)), identity
        case HalfSpace():
            slab = geometry.Box(_HALF_SPACE_WIDTH, _HALF_SPACE_WIDTH, _HALF_SPACE_DEPTH)
            return slab, RigidTransform(np.array([0.0, 0.0, -_HALF_SPACE_DEPTH / 2]))
