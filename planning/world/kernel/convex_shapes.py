"""Conversion of Drake's collision shapes to the kernel's convex shapes."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    Sphere,
)

from planning.kernel.shape import ConvexShape, ShapeKind

# Angle of normals below which faces of a hull are one face [rad].
_SAME_NORMAL = 1e-7
# Number of cached hulls: those of a few dozen robots.
_MAX_HULLS = 1024
_hull_cache: dict[tuple[Any, ...], ConvexShape] = {}


def convex_shape(shape: Any) -> ConvexShape | None:  # noqa: PLR0911  (one case per shape)
    """Return the convex body that Drake uses for a shape; None if it is of an unknown kind."""
    match shape:
        case Box():
            return _primitive(ShapeKind.BOX, *(np.asarray(shape.size()) / 2).tolist())
        case Sphere():
            return _primitive(ShapeKind.SPHERE, shape.radius())
        case Cylinder():
            return _primitive(ShapeKind.CYLINDER, shape.radius(), shape.length() / 2)
        case Capsule():
            return _primitive(ShapeKind.CAPSULE, shape.radius(), shape.length() / 2)
        case Ellipsoid():
            return _primitive(ShapeKind.ELLIPSOID, shape.a(), shape.b(), shape.c())
        case HalfSpace():
            return _primitive(ShapeKind.HALF_SPACE)
        case Convex() | Mesh():
            return _hull_of(shape)
        case _:
            return None


# Many objects of a scene have the same size.
@lru_cache(maxsize=4096)
def _primitive(kind: ShapeKind, *sizes: float) -> ConvexShape:
    size = np.zeros(3)
    size[: len(sizes)] = sizes
    return ConvexShape(kind, size, np.zeros((0, 3)), np.zeros((0, 4)))


def _hull_of(shape: Any) -> ConvexShape:
    """Return the hull of a mesh, cached by file and scale: computing it takes milliseconds."""
    source = shape.source()
    if not source.is_path():
        return _hull(shape.GetConvexHull())
    path = Path(source.path())
    status = path.stat()
    key = (str(path), status.st_mtime_ns, status.st_size, *np.asarray(shape.scale3()).tolist())
    if key not in _hull_cache:
        while len(_hull_cache) >= _MAX_HULLS:
            _hull_cache.pop(next(iter(_hull_cache)), None)
        _hull_cache[key] = _hull(shape.GetConvexHull())
    return _hull_cache[key]


def _hull(mesh: Any) -> ConvexShape:
    """Return a hull with every face once, moved outwards until it contains every vertex.

    Of a flat hull Drake has one face alone, whose other side is added: a point behind it is not
    inside the hull.
    """
    vertices = np.array([mesh.vertex(i) for i in range(mesh.num_vertices())])
    normals = np.array([mesh.face_normal(i) for i in range(mesh.num_faces())])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    _, first = np.unique(np.round(normals / _SAME_NORMAL), axis=0, return_index=True)
    faces = normals[np.sort(first)]
    if len(faces) == 1:
        faces = np.concatenate([faces, -faces])
    return ConvexShape(
        ShapeKind.HULL,
        np.zeros(3),
        vertices,
        np.column_stack([faces, (vertices @ faces.T).max(axis=0)]),
    )
