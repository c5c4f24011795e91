"""Solid: depth, tangent planes and extents of a bounded convex shape, for coverings."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.errors import ModelInvalid
from planning.kernel.shape import ConvexShape, ShapeKind

_NUM_BISECTIONS = 20


@dataclass(frozen=True)
class Solid:
    """Bounded convex shape."""

    shape: ConvexShape

    @classmethod
    def of(cls, shape: ConvexShape) -> "Solid":
        """Return the solid of a shape.

        Raises:
            ModelInvalid: A half space is unbounded.
        """
        if shape.kind is ShapeKind.HALF_SPACE:
            raise _unbounded()
        return cls(shape)

    @cached_property
    def low(self) -> Float64[np.ndarray, " 3"]:
        """Least coordinates [m], shape (3,)."""
        return self._extents[0]

    @cached_property
    def high(self) -> Float64[np.ndarray, " 3"]:
        """Greatest coordinates [m], shape (3,)."""
        return self._extents[1]

    @property
    def width(self) -> float:
        """Least extent along its axes [m]."""
        return float((self.high - self.low).min())

    @property
    def rounding_margin(self) -> float:
        """Rounding margin [m]: larger than rounding errors of lengths computed from the shape's."""
        return 1e-9 * float(np.abs([self.low, self.high]).max())

    def depth(self, points: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, " n"]:
        """Return the distance of points from the surface [m], or less; negative outside."""
        size = self.shape.size
        match self.shape.kind:
            case ShapeKind.BOX:
                return (size - np.abs(points)).min(axis=1)
            case ShapeKind.CYLINDER:
                radial_depth = size[0] - np.hypot(points[:, 0], points[:, 1])
                return np.minimum(radial_depth, size[1] - np.abs(points[:, 2]))
            case ShapeKind.ELLIPSOID:
                return _depth_in_ellipsoid(points, size)
            case ShapeKind.HULL:
                planes = self.shape.planes
                return (planes[:, 3] - _heights_along_normals(points, planes)).min(axis=1)
            case ShapeKind.SPHERE | ShapeKind.CAPSULE:
                return size[0] - np.linalg.norm(points - self._on_axis(points), axis=1)
            case ShapeKind.HALF_SPACE:
                raise _unbounded()

    def tangents(self, points: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "n 4"]:
        """Return a plane per point that has the whole shape below it, and a point outside above.

        As rows (n, d): unit normal n, and n . x <= d for every x of the shape.
        """
        size = self.shape.size
        match self.shape.kind:
            case ShapeKind.HULL:
                planes = self.shape.planes
                return planes[
                    np.argmax(_heights_along_normals(points, planes) - planes[:, 3], axis=1)
                ]
            case ShapeKind.BOX:
                normals = np.eye(3)[np.argmax(np.abs(points) - size, axis=1)] * np.sign(points)
                return np.column_stack([normals, np.abs(normals) @ size])
            case ShapeKind.ELLIPSOID:
                normals = _unit(points / size**2)
                return np.column_stack([normals, np.linalg.norm(normals * size, axis=1)])
            case ShapeKind.CYLINDER:
                normals = _unit(points * [1.0, 1.0, 0.0])
                return np.column_stack([normals, np.full(len(points), size[0])])
            case ShapeKind.SPHERE | ShapeKind.CAPSULE:
                foot = self._on_axis(points)
                normals = _unit(points - foot)
                return np.column_stack([normals, (normals * foot).sum(axis=1) + size[0]])
            case ShapeKind.HALF_SPACE:
                raise _unbounded()

    @property
    def _extents(self) -> tuple[Array, Array]:
        """Least and greatest coordinates."""
        a, b, c = self.shape.size
        match self.shape.kind:
            case ShapeKind.HULL:
                return self.shape.vertices.min(axis=0), self.shape.vertices.max(axis=0)
            case ShapeKind.BOX | ShapeKind.ELLIPSOID:
                half = np.array([a, b, c])
            case ShapeKind.CYLINDER:
                half = np.array([a, a, b])
            case ShapeKind.SPHERE | ShapeKind.CAPSULE:
                half = np.array([a, a, a + b])
            case ShapeKind.HALF_SPACE:
                raise _unbounded()
        return -half, half

    def _on_axis(self, points: Array) -> Array:
        """Return the nearest points of a capsule's axis; a sphere's is its middle."""
        feet = np.zeros_like(points)
        feet[:, 2] = np.clip(points[:, 2], -self.shape.size[1], self.shape.size[1])
        return feet


def _unbounded() -> ModelInvalid:
    reason = "a half_space is unbounded, so no finite set of spheres covers it"
    return ModelInvalid(reason, {"reason": reason})


def _heights_along_normals(points: Array, planes: Array) -> Array:
    # Not by a matrix product: threads of BLAS cost more here than they save.
    return np.einsum("ni,fi->nf", points, planes[:, :3])


def _unit(vectors: Array) -> Array:
    lengths = np.linalg.norm(vectors, axis=1)[:, None]
    return np.where(lengths > 0, vectors / np.where(lengths > 0, lengths, 1.0), [1.0, 0.0, 0.0])


def _depth_in_ellipsoid(points: Array, axes: Array) -> Array:
    """Return the distance from the surface by its dual, which bounds it from below.

    The least |y - p|^2 over sum y_i^2 / a_i^2 = 1 is the largest, over 0 <= m < min a_i^2, of
    m (1 - sum p_i^2 / (a_i^2 - m)); any m gives a lower bound (Boyd and Vandenberghe, "Convex
    Optimization", appendix B). Its slope falls in m, so halving finds the best one.
    """
    squares, p = axes**2, points**2
    low, high = np.zeros(len(points)), np.full(len(points), squares.min() * (1 - 1e-12))
    for _ in range(_NUM_BISECTIONS):
        m = (low + high) / 2
        is_increasing = (p * squares / (squares - m[:, None]) ** 2).sum(axis=1) < 1
        low, high = np.where(is_increasing, m, low), np.where(is_increasing, high, m)
    bound = low * (1 - (p / (squares - low[:, None])).sum(axis=1))
    scaled_norm = np.linalg.norm(points / axes, axis=1)
    outside = (1 - scaled_norm) * axes.min()
    return np.where(scaled_norm < 1, np.sqrt(np.maximum(bound, 0.0)), outside)
