"""Spheres around collision geometry, in the frames of the bodies that carry it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryId,
    Mesh,
    Role,
    Sphere,
)
from pydrake.multibody.tree import BodyIndex

from planning.world.drake_model import DrakeModel

type Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class BoundingSpheres:
    """A sphere per collision geometry.

    Attributes:
        bodies: The bodies that carry geometry, in the order of `first`.
        first: Index of each body's first sphere, for `np.ufunc.reduceat`, shape (num_bodies,).
        centers: p_BC in the body's frame [m], shape (num_spheres, 3).
        radii: [m], infinite for shapes without end, shape (num_spheres,).
        body_of: The body of every geometry.
    """

    bodies: tuple[BodyIndex, ...]
    first: np.ndarray[Any, np.dtype[np.intp]]
    centers: Float64[np.ndarray, "num_spheres 3"]
    radii: Float64[np.ndarray, " num_spheres"]
    body_of: dict[GeometryId, BodyIndex]


def bounding_spheres(model: DrakeModel) -> BoundingSpheres:
    """Return a sphere around every proximity geometry of the model."""
    inspector = model.scene_graph.model_inspector()
    by_body: dict[BodyIndex, list[tuple[Array, float]]] = {}
    body_of: dict[GeometryId, BodyIndex] = {}
    for geometry in inspector.GetAllGeometryIds(Role.kProximity):
        body = model.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry)).index()
        center, radius = _sphere_around(inspector, geometry)
        x_bg = inspector.GetPoseInFrame(geometry)
        by_body.setdefault(body, []).append((x_bg.multiply(center), radius))
        body_of[geometry] = body
    bodies = tuple(by_body)
    counts = [len(by_body[body]) for body in bodies]
    spheres = [sphere for body in bodies for sphere in by_body[body]]
    return BoundingSpheres(
        bodies=bodies,
        first=np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.intp),
        centers=np.array([center for center, _ in spheres]).reshape(-1, 3),
        radii=np.array([radius for _, radius in spheres]),
        body_of=body_of,
    )


def _sphere_around(inspector: Any, geometry: GeometryId) -> tuple[Array, float]:
    """Return the centre, in the geometry's frame, and radius of a sphere around a shape."""
    shape = inspector.GetShape(geometry)
    match shape:
        case Box():
            radius = float(np.linalg.norm(shape.size()) / 2)
        case Sphere():
            radius = shape.radius()
        case Cylinder():
            radius = float(np.hypot(shape.radius(), shape.length() / 2))
        case Capsule():
            radius = shape.radius() + shape.length() / 2
        case Ellipsoid():
            radius = max(shape.a(), shape.b(), shape.c())
        case Convex() | Mesh():
            return _sphere_around_hull(shape)
        case _:
            radius = np.inf
    return np.zeros(3), radius


def _sphere_around_hull(shape: Any) -> tuple[Array, float]:
    hull = shape.GetConvexHull()
    vertices = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
    center = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    return center, float(np.linalg.norm(vertices - center, axis=1).max())
