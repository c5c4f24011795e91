"""Convex shapes for tests, and what is true of them, computed without the code that is tested."""

import numpy as np
from pydrake.geometry import Convex

from planning.kernel.shape import ConvexShape, ShapeKind
from planning.world.kernel.convex_shapes import convex_shape

Kind = ShapeKind


def body(kind: ShapeKind, a: float, b: float, c: float) -> ConvexShape:
    used = {Kind.BOX: 3, Kind.ELLIPSOID: 3, Kind.SPHERE: 1, Kind.HALF_SPACE: 0}.get(kind, 2)
    size = np.array([a, b, c]) * (np.arange(3) < used)
    return ConvexShape(kind, size, np.zeros((0, 3)), np.zeros((0, 4)))


def hull(seed: int, count: int, a: float, b: float, c: float) -> ConvexShape:
    """Return the hull of random points, on a sphere or in a box or on a grid, then stretched."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3))
    if seed % 3 == 0:
        points /= np.linalg.norm(points, axis=1)[:, None]
    elif seed % 3 == 1:
        points = np.round(rng.uniform(-2, 2, (count, 3)))
    points = np.concatenate([points, np.eye(3), -np.eye(3)]) * [a, b, c]
    shape = convex_shape(Convex(np.asfortranarray(points.T), "hull"))
    assert shape is not None
    return shape


def inside(shape: ConvexShape, rng: np.random.Generator, count: int) -> np.ndarray:
    """Return points all over the shape."""
    a, b, _ = shape.size
    cube = rng.uniform(-1, 1, (count, 3))
    ball = _directions(rng, count) * rng.uniform(0, 1, (count, 1)) ** (1 / 3)
    match shape.kind:
        case Kind.BOX:
            return cube * shape.size
        case Kind.CYLINDER:
            return _disc(rng, count) * a + cube * [0, 0, b]
        case Kind.CAPSULE | Kind.SPHERE:
            return ball * a + cube * [0, 0, b]
        case Kind.ELLIPSOID:
            return ball * shape.size
        case Kind.HALF_SPACE:
            return cube - [0, 0, 1]
        case Kind.HULL:
            # Few corners weigh much in most points, all of them in some.
            sharp = rng.dirichlet(np.full(len(shape.vertices), 0.05), count)
            return np.concatenate([sharp @ shape.vertices, shape.vertices])


def on_surface(shape: ConvexShape, rng: np.random.Generator, count: int) -> np.ndarray:
    """Return points of the surface, many of them on edges and corners."""
    a, b, _ = shape.size
    ends = np.sign(rng.uniform(-1, 1, (count, 3)))
    match shape.kind:
        case Kind.BOX:
            fixed = rng.uniform(0, 1, (count, 3)) < 0.6
            return np.where(fixed, ends, rng.uniform(-1, 1, (count, 3))) * shape.size
        case Kind.CYLINDER:
            disc, heights = _disc(rng, count), rng.uniform(-1, 1, (count, 1))
            rim = disc / np.linalg.norm(disc, axis=1)[:, None]
            up = np.array([0, 0, b])
            wall, lids, rims = rim * a + heights * up, disc * a + ends * up, rim * a + ends * up
            return np.concatenate([wall, lids, rims])
        case Kind.CAPSULE | Kind.SPHERE:
            n = _directions(rng, count)
            side = n * [1, 1, 0]
            side /= np.linalg.norm(side, axis=1)[:, None]
            wall = side * a + rng.uniform(-1, 1, (count, 1)) * [0, 0, b]
            return np.concatenate([n * a + np.sign(n) * [0, 0, b], wall])
        case Kind.ELLIPSOID:
            return _directions(rng, count) * shape.size
        case Kind.HALF_SPACE:
            return rng.uniform(-1, 1, (count, 3)) * [1, 1, 0]
        case Kind.HULL:
            return _on_hull(shape, rng, count)


def _on_hull(shape: ConvexShape, rng: np.random.Generator, count: int) -> np.ndarray:
    """Return mixtures of the corners of each face."""
    size = np.abs(shape.vertices).max()
    per_face = max(4, count // len(shape.planes))
    found = []
    for n, d in zip(shape.planes[:, :3], shape.planes[:, 3], strict=True):
        corners = shape.vertices[shape.vertices @ n >= d - 1e-9 * size]
        found.append(rng.dirichlet(np.full(len(corners), 0.5), per_face) @ corners)
    return np.concatenate(found)


def depth(shape: ConvexShape, points: np.ndarray) -> np.ndarray:
    """Return the distance from points inside to the surface."""
    a, b, _ = shape.size
    match shape.kind:
        case Kind.BOX:
            return (shape.size - np.abs(points)).min(axis=1)
        case Kind.CYLINDER:
            sideways = a - np.linalg.norm(points[:, :2], axis=1)
            return np.minimum(sideways, b - np.abs(points[:, 2]))
        case Kind.ELLIPSOID:
            # By brute force, from above: what is beyond the true distance shows no fault.
            n = _directions(np.random.default_rng(6), 20_000) * shape.size
            return np.array([np.linalg.norm(n - p, axis=1).min() for p in points])
        case Kind.HULL:
            return (shape.planes[:, 3] - points @ shape.planes[:, :3].T).min(axis=1)
        case Kind.HALF_SPACE:
            return -points[:, 2]
        case Kind.CAPSULE | Kind.SPHERE:
            return a - _from_axis(points, b)


def distance(shape: ConvexShape, points: np.ndarray) -> np.ndarray:
    """Return the distance from points to the shape, 0 inside; of hulls and ellipsoids, a bound."""
    a, b, _ = shape.size
    match shape.kind:
        case Kind.BOX:
            return np.linalg.norm(np.maximum(np.abs(points) - shape.size, 0), axis=1)
        case Kind.CYLINDER:
            sideways = np.maximum(np.linalg.norm(points[:, :2], axis=1) - a, 0)
            return np.hypot(sideways, np.maximum(np.abs(points[:, 2]) - b, 0))
        case Kind.ELLIPSOID:
            return _below(points, _directions(np.random.default_rng(7), 4000), shape)
        case Kind.HULL:
            return _below(points, _directions(np.random.default_rng(8), 4000), shape)
        case Kind.HALF_SPACE:
            return np.maximum(points[:, 2], 0)
        case Kind.CAPSULE | Kind.SPHERE:
            return np.maximum(_from_axis(points, b) - a, 0)


def _below(points: np.ndarray, normals: np.ndarray, shape: ConvexShape) -> np.ndarray:
    """Return the largest height of points over many tangent planes: at most their distance."""
    if shape.kind is Kind.HULL:
        normals = np.concatenate([normals, shape.planes[:, :3]])
        tops = (normals @ shape.vertices.T).max(axis=1)
    else:
        tops = np.linalg.norm(normals * shape.size, axis=1)
    return np.maximum((points @ normals.T - tops).max(axis=1), 0)


def _from_axis(points: np.ndarray, half_length: float) -> np.ndarray:
    along = np.maximum(np.abs(points[:, 2]) - half_length, 0)
    return np.linalg.norm(np.column_stack([points[:, :2], along]), axis=1)


def _directions(rng: np.random.Generator, count: int) -> np.ndarray:
    n = rng.normal(size=(count, 3))
    return n / np.linalg.norm(n, axis=1)[:, None]


def _disc(rng: np.random.Generator, count: int) -> np.ndarray:
    angles, radii = rng.uniform(0, 2 * np.pi, count), np.sqrt(rng.uniform(0, 1, count))
    return np.column_stack([radii * np.cos(angles), radii * np.sin(angles), np.zeros(count)])
