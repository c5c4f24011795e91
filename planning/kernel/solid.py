"""Solid: a convex shape as coverings see it."""

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.errors import ModelInvalid
from planning.kernel.pieces import Piece
from planning.kernel.shape import ConvexShape, ShapeKind

type Array = np.ndarray[Any, np.dtype[np.float64]]

_SIDES = 20
_GRID = 12
_BANDS = 10


@dataclass(frozen=True)
class Solid:
    """A convex shape with a polytope around it.

    Attributes:
        shape: The shape itself.
        polytope: One that contains it.
        inside: Points of a grid that lie inside the shape, shape (n, 3).
        deepest: The one of them that is farthest from the surface, or the middle, shape (3,).
        width: The least extent along its axes [m].
    """

    shape: ConvexShape
    polytope: Piece
    inside: Float64[np.ndarray, "n 3"]
    deepest: Float64[np.ndarray, "3"]
    width: float

    @classmethod
    def of(cls, shape: ConvexShape) -> "Solid":
        """Return the solid of a shape that has an end on every side."""
        polytope = _polytope(shape)
        low, high = polytope.low, polytope.high
        middle = (low + high) / 2
        solid = cls(shape, polytope, np.zeros((0, 3)), middle, float((high - low).min()))
        steps = [np.linspace(a, b, _GRID + 2)[1:-1] for a, b in zip(low, high, strict=True)]
        grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
        deep = solid.depth(grid)
        deepest = grid[int(np.argmax(deep))] if (deep > 0).any() else middle
        return cls(shape, polytope, grid[deep > 0], deepest, solid.width)

    def depth(self, points: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, " n"]:
        """Return a lower bound on the distance from points to the surface, negative outside [m]."""
        size = self.shape.size
        match self.shape.kind:
            case ShapeKind.BOX:
                return (size - np.abs(points)).min(axis=1)
            case ShapeKind.SPHERE:
                return size[0] - np.linalg.norm(points, axis=1)
            case ShapeKind.CYLINDER:
                sideways = size[0] - np.hypot(points[:, 0], points[:, 1])
                return np.minimum(sideways, size[1] - np.abs(points[:, 2]))
            case ShapeKind.CAPSULE:
                along = np.clip(points[:, 2], -size[1], size[1])
                away = points - np.stack([0 * along, 0 * along, along], axis=1)
                return size[0] - np.linalg.norm(away, axis=1)
            case ShapeKind.ELLIPSOID:
                # The unit ball's depth, stretched at least by the shortest axis.
                return (1 - np.linalg.norm(points / size, axis=1)) * size.min()
            case _:
                planes = self.shape.planes
                return (planes[:, 3] - points @ planes[:, :3].T).min(axis=1)


def _polytope(shape: ConvexShape) -> Piece:
    size = shape.size
    match shape.kind:
        case ShapeKind.BOX:
            return _box(size)
        case ShapeKind.CYLINDER:
            return _prism(size[0], size[1])
        case ShapeKind.CAPSULE:
            return _prism(size[0], size[1] + size[0])
        case ShapeKind.ELLIPSOID:
            return _around_ellipsoid(size)
        case ShapeKind.HULL:
            return Piece.of(shape.vertices, shape.planes)
        case _:
            message = f"a {shape.kind} has no covering of many spheres"
            raise ModelInvalid(message, {"reason": message})


def _box(half: Array) -> Piece:
    corners = np.array(list(product((-1.0, 1.0), repeat=3))) * half
    planes = [(*sign * axis, half[i]) for i, axis in enumerate(np.eye(3)) for sign in (1.0, -1.0)]
    return Piece.of(corners, np.array(planes))


def _prism(radius: float, half_length: float) -> Piece:
    """Return a prism around a cylinder."""
    angles = 2 * np.pi * np.arange(_SIDES) / _SIDES
    turned = angles + np.pi / _SIDES
    ring = np.stack([np.cos(turned), np.sin(turned)], axis=1) * radius / np.cos(np.pi / _SIDES)
    ends = (-half_length, half_length)
    corners = np.concatenate([np.column_stack([ring, np.full(_SIDES, z)]) for z in ends])
    planes = [(np.cos(a), np.sin(a), 0.0, radius) for a in angles]
    planes += [(0.0, 0.0, 1.0, half_length), (0.0, 0.0, -1.0, half_length)]
    return Piece.of(corners, np.array(planes))


def _around_ellipsoid(axes: Array) -> Piece:
    """Return the image of a polytope around the unit ball: bands of quadrilaterals.

    Its corners lie on latitudes and longitudes, pushed out until every face is outside the ball.
    """
    up = np.linspace(-np.pi / 2, np.pi / 2, _BANDS + 1)
    round_ = 2 * np.pi * np.arange(_SIDES) / _SIDES
    grid = np.array([
        (np.cos(a) * np.cos(b), np.cos(a) * np.sin(b), np.sin(a)) for a in up for b in round_
    ])
    corners = np.unique(np.round(grid, 12), axis=0)
    middles = [
        (np.cos(a) * np.cos(b), np.cos(a) * np.sin(b), np.sin(a))
        for a in (up[1:] + up[:-1]) / 2
        for b in round_ + np.pi / _SIDES
    ]
    found: list[Array] = []
    for middle in np.array(middles):
        nearest = corners[np.argsort(-(corners @ middle), kind="stable")[:4]]
        normal = np.linalg.svd(nearest[:4] - nearest[:4].mean(axis=0))[2][2]
        normal = normal if normal @ middle > 0 else -normal
        found.append(np.append(normal, (corners @ normal).max()))
    planes = np.array(found)
    corners, planes[:, 3] = corners / planes[:, 3].min(), planes[:, 3] / planes[:, 3].min()
    normals = planes[:, :3] / axes
    lengths = np.linalg.norm(normals, axis=1)
    stretched = np.column_stack([normals / lengths[:, None], planes[:, 3] / lengths])
    return Piece.of(corners * axes, stretched)
