"""Support functions: the point of a convex shape that lies farthest along a direction."""

import math

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.errors import ModelInvalid
from planning.kernel.shape import ConvexShape, ShapeKind


def farthest_point(shape: ConvexShape, n: Float64[np.ndarray, "3"]) -> Float64[np.ndarray, "3"]:
    """Return the point of a shape G that lies farthest along a unit vector n, both in G [m].

    Raises:
        ModelInvalid: A half space has none.
    """
    size = shape.size
    match shape.kind:
        case ShapeKind.BOX:
            return np.copysign(size, n)
        case ShapeKind.SPHERE:
            return size[0] * n
        case ShapeKind.CYLINDER:
            x, y = size[0] * _unit(n[:2])
            return np.array([x, y, np.copysign(size[1], n[2])])
        case ShapeKind.CAPSULE:
            return size[0] * n + np.array([0.0, 0.0, np.copysign(size[1], n[2])])
        case ShapeKind.ELLIPSOID:
            return size * _unit(size * n)
        case ShapeKind.HULL:
            return shape.vertices[np.argmax(shape.vertices @ n)]
        case ShapeKind.HALF_SPACE:
            raise no_farthest_point()


def no_farthest_point() -> ModelInvalid:
    """Return the error of a half space where a bounded shape is needed."""
    message = "a half_space is unbounded and has no farthest point along a direction"
    return ModelInvalid(message, {"reason": message})


def _unit(vector: Array) -> Array:
    """Return a vector of length 1; zero stays zero."""
    length = math.sqrt(vector.dot(vector))
    return vector / length if length > 0 else vector
