"""Distances between placed shapes, by coal; half spaces by support functions.

Everything is measured in units of the attack's size, because coal's tolerances are absolute. What
coal says of a pair is confirmed, before it is held against a proof, by `witness_points.py`.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import coal
import numpy as np

from planning.domain.arrays import Array
from tests.adversary.draws.shapes import Shape, heights, points_of, radius_of, scaled

_UNIT = coal.DistanceRequest()
_UNIT.gjk_tolerance = 1e-9
_UNIT.epa_tolerance = 1e-9
_UNIT.gjk_max_iterations = 1000
_UNIT.epa_max_iterations = 500


@dataclass(frozen=True)
class Solid:
    """A shape of a body: where it is at n instants, X_WG, shape (n, 4, 4) [m]."""

    body: str
    shape: Shape
    poses: Array
    geometry: Any
    radius: float

    @property
    def is_half_space(self) -> bool:
        return "half_space" in self.shape

    def at(self, i: int) -> "Solid":
        """Return the solid at one instant alone."""
        return replace(self, poses=self.poses[i : i + 1])

    @property
    def middles(self) -> Array:
        return self.poses[:, :3, 3]


def make_geometry(  # noqa: PLR0911  (one return per shape)
    shape: Shape, size: float
) -> Any:
    """Return coal's shape in units of `size`; None for a half space, which needs none."""
    if "half_space" in shape:
        return None
    small = scaled(shape, 1.0 / size)
    ((kind, value),) = small.items()
    match kind:
        case "box":
            return coal.Box(*value)
        case "sphere":
            return coal.Sphere(value)
        case "cylinder":
            return coal.Cylinder(value["radius"], value["length"])
        case "capsule":
            return coal.Capsule(value["radius"], value["length"])
        case "ellipsoid":
            return coal.Ellipsoid(*value)
        case _:
            points = coal.StdVec_Vec3s()
            points.extend(list(np.array(value["points"])))
            return coal.ConvexBase.convexHull(points, False, "Qt")


def make_solid(body: str, shape: Shape, poses: Array, size: float) -> Solid:
    """Return a shape at n poses, shape (n, 4, 4) or (4, 4)."""
    return Solid(body, shape, poses, make_geometry(shape, size), radius_of(shape))


def distance(a: Solid, b: Solid, i: int, size: float) -> tuple[float, Array]:
    """Return the signed distance [m] at instant i, and the direction from b to a along it."""
    if b.is_half_space:
        return _above(a, b, i)
    if a.is_half_space:
        gap, normal = _above(b, a, i)
        return gap, -normal
    found = coal.DistanceResult()
    places = [coal.Transform3s(s.poses[i, :3, :3], s.poses[i, :3, 3] / size) for s in (a, b)]
    gap = coal.distance(a.geometry, places[0], b.geometry, places[1], _UNIT, found) * size
    normal = -np.array(found.normal)
    # Where coal's search for the depth fails it says minus infinity, or nearly.
    if not (gap > -a.radius - b.radius and np.isfinite(normal).all()):
        return _depth(a, b, i)
    return gap, normal


def _depth(a: Solid, b: Solid, i: int) -> tuple[float, Array]:
    """Return a bound on how deep two shapes overlap, by many directions, as a distance [m]."""
    normals = np.random.default_rng(0).normal(size=(2000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    reach = heights(b.shape, normals @ b.poses[i, :3, :3])
    reach += heights(a.shape, -normals @ a.poses[i, :3, :3])
    overlap = reach - normals @ (a.poses[i, :3, 3] - b.poses[i, :3, 3])
    least = int(np.argmin(overlap))
    return -float(overlap[least]), normals[least]


def _above(solid: Solid, ground: Solid, i: int) -> tuple[float, Array]:
    """Return how far the lowest point of a solid is above a half space."""
    normal, point = ground.poses[i, :3, 2], ground.poses[i, :3, 3]
    down = -normal @ solid.poses[i, :3, :3]
    low = float(heights(solid.shape, down[None])[0])
    return float(normal @ (solid.poses[i, :3, 3] - point)) - low, normal


def lower_bounds(a: Solid, b: Solid) -> Array:
    """Return bounds on the distance from below at all instants, by balls, shape (n,)."""
    if a.is_half_space or b.is_half_space:
        solid, ground = (b, a) if a.is_half_space else (a, b)
        normals = ground.poses[:, :3, 2]
        down = np.einsum("nj,njk->nk", -normals, solid.poses[:, :3, :3])
        away = np.einsum("nj,nj->n", normals, solid.middles - ground.middles)
        return away - heights(solid.shape, down)
    return np.linalg.norm(a.middles - b.middles, axis=1) - a.radius - b.radius


@dataclass(frozen=True)
class Near:
    """The nearest that two bodies were found: spare is distance less margin [m]."""

    spare: float
    distance: float
    pair: tuple[str, str]
    index: int
    solids: tuple[Solid, Solid]
    normal: Array


def nearest(
    pairs: list[tuple[Solid, Solid, float]], size: float, most: int = 600
) -> Iterator[Near]:
    """Yield what is nearer its margin than all that was measured before; the last is the nearest.

    Args:
        pairs: Solids with the same instants, and the margin to keep [m].
        size: Of the attack [m].
        most: Distances to measure at most.
    """
    if not pairs:
        return
    bounds = np.stack([lower_bounds(a, b) - margin for a, b, margin in pairs])
    best = np.inf
    for flat in np.argsort(bounds, axis=None)[:most]:
        row, i = np.unravel_index(flat, bounds.shape)
        if bounds[row, i] >= best:
            return
        a, b, margin = pairs[row]
        gap, normal = distance(a, b, int(i), size)
        if gap - margin < best:
            best = gap - margin
            yield Near(best, gap, (a.body, b.body), int(i), (a, b), normal)


def corners_of(solid: Solid, i: int) -> Array | None:
    """Return the corners in world of what has corners, shape (m, 3)."""
    points = points_of(solid.shape)
    return None if points is None else points @ solid.poses[i, :3, :3].T + solid.poses[i, :3, 3]
