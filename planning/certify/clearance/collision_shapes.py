"""CollisionShapes: support functions and bounding spheres of a model's collision geometry.

Every convex shape here is the sum of a polytope, an ellipsoid (maybe flat) and a ball, so

    h(n) = max_{x in shape} n . x = max_i n . v_i + |D n| + r |n|

is exact: a box is eight vertices, a cylinder two and a flat disk, a capsule two and a ball. For any
unit vector n the slab between two shapes, min_{a in A} n . a - max_{b in B} n . b, is a lower bound
on their distance, and the best n attains it (Boyd and Vandenberghe, "Convex Optimization", 2004,
section 8.2.2). So any direction n, whatever its source, gives a proven bound.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryId,
    HalfSpace,
    Mesh,
    Sphere,
)

from planning.domain.arrays import Array
from planning.errors import ModelInvalid
from planning.world.collision.collision_pairs import collision_pairs_of
from planning.world.drake_model import DrakeModel


@dataclass(frozen=True)
class _Summands:
    """Summands of a shape: polytope, shape (k, 3), semi-axes, shape (3,), and ball radius [m]."""

    vertices: Array
    semi_axes: Array
    ball_radius: float


@dataclass(frozen=True)
class CollisionShapes:
    """Collision geometry of a model, a row per Drake geometry.

    Attributes:
        rows: Row by Drake's id.
        bodies: Index of its body, shape (n,).
        R_BG: Orientation in the body's frame, shape (n, 3, 3).
        p_bg: Position in the body's frame [m], shape (n, 3).
        vertices: Vertices of the polytopes in G, padded by repetition [m], shape (n, k, 3).
        semi_axes: Semi-axes of the ellipsoids in G [m], shape (n, 3).
        ball_radii: Radii of the balls [m], shape (n,).
        centers: Centres of the bounding spheres in the body's frame [m], shape (n, 3).
        radii: Radii of the bounding spheres [m], infinite for half spaces, shape (n,).
        is_half_space: Whether the shape is the half space z <= 0 in G, shape (n,).
    """

    rows: dict[GeometryId, int]
    bodies: Int[np.ndarray, " n"]
    R_BG: Float64[np.ndarray, "n 3 3"]
    p_bg: Float64[np.ndarray, "n 3"]
    vertices: Float64[np.ndarray, "n k 3"]
    semi_axes: Float64[np.ndarray, "n 3"]
    ball_radii: Float64[np.ndarray, " n"]
    centers: Float64[np.ndarray, "n 3"]
    radii: Float64[np.ndarray, " n"]
    is_half_space: Bool[np.ndarray, " n"]

    def support(self, rows: Any, R_WG: Array, p_wg: Array, n: Array) -> Array:
        """Return the support function max n . x over the points x of each shape [m], shape (m,).

        Args:
            rows: Rows of the shapes, shape (m,); no half spaces.
            R_WG: Their orientations, shape (m, 3, 3).
            p_wg: Their positions [m], shape (m, 3).
            n: A unit vector for each, shape (m, 3).
        """
        n_local = (n[:, None, :] @ R_WG)[:, 0]
        corner = (self.vertices[rows] @ n_local[:, :, None])[:, :, 0].max(axis=1)
        disk = np.sqrt(((self.semi_axes[rows] * n_local) ** 2).sum(axis=1))
        return (p_wg * n).sum(axis=1) + corner + disk + self.ball_radii[rows]

    def support_point(self, row: int, R_WG: Array, p_wg: Array, n: Array) -> Array:
        """Return the support point: the point of one shape farthest along n [m], shape (3,)."""
        n_local = R_WG.T @ n
        point = self.vertices[row][np.argmax(self.vertices[row] @ n_local)]
        size = np.linalg.norm(self.semi_axes[row] * n_local)
        if size > 0:
            point = point + self.semi_axes[row] ** 2 * n_local / size
        return R_WG @ (point + self.ball_radii[row] * n_local / np.linalg.norm(n_local)) + p_wg


def collision_shapes(
    model: DrakeModel, chosen: Collection[GeometryId] | None = None
) -> CollisionShapes:
    """Return the collision (proximity) geometry of a model.

    Args:
        model: The scene.
        chosen: Ids of the only shapes to return, by which a hull of many vertices costs less; None
            for all.

    Raises:
        ModelInvalid: A shape of a kind that cannot be certified.
    """
    inspector, standing = model.scene_graph.model_inspector(), model.static_objects
    pairs = collision_pairs_of(model)
    first = pairs.num_drake_shapes
    picked = _rows(pairs.ids, first, standing.row_of, chosen)
    ids = [pairs.ids[row] for row in picked]
    shapes: list[Any] = []
    poses: list[Any] = []
    for row, geometry in zip(picked, ids, strict=True):
        is_drakes = row < first
        shapes.append(
            inspector.GetShape(geometry) if is_drakes else standing.drake_shapes[row - first]
        )
        poses.append(
            inspector.GetPoseInFrame(geometry) if is_drakes else standing.poses[row - first]
        )
    parts = [_summands(shape) for shape in shapes]
    spheres = [_sphere(shape, part) for shape, part in zip(shapes, parts, strict=True)]
    max_vertices = max((len(part.vertices) for part in parts), default=1)
    padded = [np.resize(part.vertices, (max_vertices, 3)) for part in parts]
    centers = [x.multiply(center) for x, (center, _) in zip(poses, spheres, strict=True)]
    return CollisionShapes(
        rows={geometry: row for row, geometry in enumerate(ids)},
        bodies=np.array([int(pairs.bodies[row]) for row in picked], dtype=np.intp),
        R_BG=np.array([x.rotation().matrix() for x in poses]).reshape(-1, 3, 3),
        p_bg=np.array([x.translation() for x in poses]).reshape(-1, 3),
        vertices=np.array(padded).reshape(-1, max_vertices, 3),
        semi_axes=np.array([part.semi_axes for part in parts]).reshape(-1, 3),
        ball_radii=np.array([part.ball_radius for part in parts], dtype=np.float64),
        centers=np.array(centers).reshape(-1, 3),
        radii=np.array([radius for _, radius in spheres], dtype=np.float64),
        is_half_space=np.array([isinstance(shape, HalfSpace) for shape in shapes], dtype=bool),
    )


def _rows(
    ids: Sequence[GeometryId],
    num_drake_shapes: int,
    row_of_static: Mapping[GeometryId, int],
    chosen: Collection[GeometryId] | None,
) -> list[int]:
    """Return the rows of the chosen shapes: there may be thousands that are not looked through."""
    if chosen is None:
        return list(range(len(ids)))
    rows = [row for row, i in enumerate(ids[:num_drake_shapes]) if i in chosen]
    return rows + sorted(num_drake_shapes + row_of_static[i] for i in chosen if i in row_of_static)


def _summands(shape: Any) -> _Summands:  # noqa: PLR0911  (one case per shape)
    point, no_axes = np.zeros((1, 3)), np.zeros(3)
    match shape:
        case Box():
            signs = np.array(list(product((-0.5, 0.5), repeat=3)))
            return _Summands(signs * shape.size(), no_axes, 0.0)
        case Sphere():
            return _Summands(point, no_axes, shape.radius())
        case Cylinder():
            disk = np.array([shape.radius(), shape.radius(), 0.0])
            return _Summands(_ends(shape.length()), disk, 0.0)
        case Capsule():
            return _Summands(_ends(shape.length()), no_axes, shape.radius())
        case Ellipsoid():
            return _Summands(point, np.array([shape.a(), shape.b(), shape.c()]), 0.0)
        case Convex() | Mesh():
            hull = shape.GetConvexHull()
            vertices = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
            return _Summands(vertices, no_axes, 0.0)
        case HalfSpace():
            return _Summands(point, no_axes, np.inf)
        case _:
            kind = type(shape).__name__
            message = f"collision shapes of kind {kind!r} cannot be certified"
            raise ModelInvalid(message, {"reason": message})


def _ends(length: float) -> Array:
    return np.array([[0.0, 0.0, -length / 2], [0.0, 0.0, length / 2]])


def _sphere(shape: Any, parts: _Summands) -> tuple[Array, float]:
    """Return centre (geometry frame) and radius of a bounding sphere of a shape [m]."""
    center = (parts.vertices.min(axis=0) + parts.vertices.max(axis=0)) / 2
    farthest = float(np.linalg.norm(parts.vertices - center, axis=1).max())
    if isinstance(shape, Cylinder):
        return center, float(np.hypot(farthest, shape.radius()))
    return center, farthest + float(parts.semi_axes.max()) + parts.ball_radius
