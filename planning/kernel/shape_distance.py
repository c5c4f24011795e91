"""Distance bounds of two convex shapes, by GJK on their cores.

A sphere is a point, and a capsule a line segment, with a ball around each of its points. Without
the ball the core remains, which has corners for most shapes, and `separation` finds the distance of
cores with corners exactly.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.kernel.gjk import GjkResult, separation
from planning.kernel.shape import ConvexShape, ShapeKind
from planning.kernel.support import farthest_point, no_farthest_point


def distance_bounds(
    shapes: tuple[ConvexShape, ConvexShape],
    poses: tuple[Float64[np.ndarray, "4 4"], Float64[np.ndarray, "4 4"]],
    guess: Float64[np.ndarray, "3"],
    sufficient_distance: float = np.inf,
) -> GjkResult:
    """Bound the distance of two shapes from both sides [m].

    Args:
        shapes: A and B; neither is a half space.
        poses: X_WA and X_WB.
        guess: Initial direction from B to A; zero or NaN for none.
        sufficient_distance: A lower bound as large as this ends the search [m].
    """
    offset = poses[0][:3, 3] - poses[1][:3, 3]
    core_radii = _core_radius(shapes[0]) + _core_radius(shapes[1])
    R_WA, R_WB = poses[0][:3, :3], poses[1][:3, :3]

    def support(n: Array) -> Array:
        point_on_a = R_WA @ _core_support(shapes[0], n @ R_WA)
        point_on_b = R_WB @ _core_support(shapes[1], -n @ R_WB)
        return offset + point_on_a - point_on_b

    direction = guess if np.isfinite(guess).all() and guess.any() else offset
    core_bounds = separation(
        support, direction, sufficient_distance + core_radii, gap_tolerance=0.0
    )
    return GjkResult(
        core_bounds.lower - core_radii,
        core_bounds.upper - core_radii,
        core_bounds.direction,
        core_bounds.corners,
    )


def slab_width(
    shapes: tuple[ConvexShape, ConvexShape],
    poses: tuple[Float64[np.ndarray, "4 4"], Float64[np.ndarray, "4 4"]],
    n: Float64[np.ndarray, "3"],
) -> float:
    """Return the width of the slab across n between two shapes [m]: at most their distance.

    Args:
        shapes: A and B.
        poses: X_WA and X_WB.
        n: Unit vector from B to A.
    """
    (a, b), (X_WA, X_WB) = shapes, poses
    point_on_a = X_WA[:3, :3] @ farthest_point(a, -n @ X_WA[:3, :3])
    point_on_b = X_WB[:3, :3] @ farthest_point(b, n @ X_WB[:3, :3])
    return float(n @ (X_WA[:3, 3] - X_WB[:3, 3] + point_on_a - point_on_b))


def _core_radius(shape: ConvexShape) -> float:
    """Return the radius of the ball around each point of the core [m]."""
    match shape.kind:
        case ShapeKind.SPHERE | ShapeKind.CAPSULE:
            return float(shape.size[0])
        case ShapeKind.BOX | ShapeKind.CYLINDER | ShapeKind.ELLIPSOID | ShapeKind.HULL:
            return 0.0
        case ShapeKind.HALF_SPACE:
            raise no_farthest_point()


def _core_support(shape: ConvexShape, n: Array) -> Array:
    match shape.kind:
        case ShapeKind.SPHERE:
            return np.zeros(3)
        case ShapeKind.CAPSULE:
            return np.array([0.0, 0.0, np.copysign(shape.size[1], n[2])])
        case ShapeKind.BOX | ShapeKind.CYLINDER | ShapeKind.ELLIPSOID | ShapeKind.HULL:
            return farthest_point(shape, n)
        case ShapeKind.HALF_SPACE:
            raise no_farthest_point()
