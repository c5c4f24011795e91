"""BallChoices: candidate balls of a covering, and the sample points that rate them.

About a point of depth d (its distance from the surface) the ball of radius d lies inside a convex
shape, and one of radius d + t reaches t beyond it. So one table of the distances of points from
inner balls, `gaps`, serves both: the balls of reach t hold the points whose gaps are at most t, and
the gaps that remain for a set of inner balls are the depths of undetected penetration.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.kernel.coverings.outer_polytope import OuterPolytope
from planning.kernel.coverings.solid import Solid

# Numbers of centres, rays to the surface and points on edges: for hulls of more corners than
# `_MAX_FEW_CORNERS`, and for others.
_COUNTS_FOR_MANY_CORNERS = (600, 300, 150)
_COUNTS_FOR_FEW_CORNERS = (200, 150, 60)
_MAX_FEW_CORNERS = 32
_GOLDEN_ANGLE = np.pi * (1 + 5**0.5)


@dataclass(frozen=True)
class BallChoices:
    """Candidate balls in a solid, with sample points.

    Attributes:
        centers: Of the balls: a grid, shape (n, 3).
        depths: Their distances from the surface, or less [m], shape (n,).
        points: Some on the surface, then others all over the solid, shape (m, 3).
        num_surface: Number of points that are spread over the surface.
        gaps: From each inner ball to each point, negative inside [m], shape (n, m).
        spacing: Of the grid [m].
    """

    centers: Float64[np.ndarray, "n 3"]
    depths: Float64[np.ndarray, " n"]
    points: Float64[np.ndarray, "m 3"]
    num_surface: int
    gaps: Float64[np.ndarray, "n m"]
    spacing: float

    @classmethod
    def of(cls, solid: Solid, polytope: OuterPolytope) -> "BallChoices":
        """Return the candidates in a solid; its middle is one of them in any case."""
        num_centers, num_rays, num_on_edges = (
            _COUNTS_FOR_MANY_CORNERS
            if len(solid.shape.vertices) > _MAX_FEW_CORNERS
            else _COUNTS_FOR_FEW_CORNERS
        )
        grid, spacing = _grid(solid.low, solid.high, num_centers)
        depths = solid.depth(grid)
        inside = depths >= 0
        middle = polytope.v_representation.corners.mean(axis=0)[None]
        centers = np.concatenate([grid[inside], middle[: int(not inside.any())]])
        depths = solid.depth(centers)
        surface = _surface_points(solid, polytope, num_rays)
        corners, edges = polytope.v_representation.corners, _edge_points(polytope, num_on_edges)
        points = np.concatenate([surface, corners, edges, centers[::3]])
        square = (centers**2).sum(axis=1)[:, None] + (points**2).sum(axis=1)
        square -= 2 * np.einsum("ci,pi->cp", centers, points)
        gaps = np.sqrt(np.maximum(square, 0.0)) - depths[:, None]
        return cls(centers, depths, points, len(surface), gaps, spacing)


def fibonacci_directions(count: int) -> Float64[np.ndarray, "n 3"]:
    """Return unit vectors spread evenly: Fibonacci's lattice on the sphere."""
    steps = np.arange(count) + 0.5
    z = 1 - 2 * steps / count
    r = np.sqrt(1 - z * z)
    return np.column_stack([
        r * np.cos(_GOLDEN_ANGLE * steps),
        r * np.sin(_GOLDEN_ANGLE * steps),
        z,
    ])


def _grid(low: Array, high: Array, count: int) -> tuple[Array, float]:
    """Return a grid of nearly cubic cells: at least three along every side, and a middle one."""
    extent = np.maximum(high - low, 1e-6 * (high - low).max())
    spacing = float(extent.prod() / count) ** (1 / 3)
    counts = np.ones(3)
    for _ in range(5):
        counts = np.maximum(3, np.round(extent / spacing))
        counts += 1 - counts % 2
        spacing *= float(counts.prod() / count) ** (1 / 3)
    steps = [
        a + (np.arange(n) + 0.5) / n * (b - a) for a, b, n in zip(low, high, counts, strict=True)
    ]
    grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    return grid, float((extent / counts).max())


def _surface_points(solid: Solid, polytope: OuterPolytope, count: int) -> Array:
    """Return the points where rays from the middle leave the polytope, denser where it is long."""
    middle, half = (solid.low + solid.high) / 2, (solid.high - solid.low) / 2
    rays = fibonacci_directions(count) * half
    slope = np.einsum("ri,fi->rf", rays, polytope.planes[:, :3])
    plane_distances = polytope.planes[:, 3] - polytope.planes[:, :3] @ middle
    is_leaving = slope > 1e-12 * half.max()
    ray_lengths = np.where(
        is_leaving, plane_distances / np.where(is_leaving, slope, 1.0), np.inf
    ).min(axis=1)
    return middle + np.maximum(ray_lengths, 0.0)[:, None] * rays


def _edge_points(polytope: OuterPolytope, count: int) -> Array:
    """Return points on the polytope's edges, the ends left out."""
    ends = polytope.v_representation.corners[polytope.v_representation.edges]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    counts = np.maximum(np.ceil(lengths / (lengths.sum() / count)).astype(int) - 1, 0)
    edge = np.repeat(np.arange(len(ends)), counts)
    number = np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)
    fractions = ((number + 1) / (counts[edge] + 1))[:, None]
    return ends[edge, 0] + fractions * (ends[edge, 1] - ends[edge, 0])
