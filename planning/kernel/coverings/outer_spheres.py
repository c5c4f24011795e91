"""Outer spheres: few balls that contain a convex shape and reach little beyond it.

A ball of radius r about a point of depth d (its distance from the surface) reaches r - d beyond a
convex shape: shrunk about that point by d / r it lies inside. A polytope around the shape is
partitioned among balls (power cells), and each centre moves to where the ball about its own cell
reaches least, again and again: Lloyd's algorithm, for the farthest reach instead of the mean
square. The cells cover the polytope, so the balls contain the shape from any initial centres.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.kernel.coverings.ball_choices import BallChoices, fibonacci_directions
from planning.kernel.coverings.capsule_spheres import capsule_spheres
from planning.kernel.coverings.initial_spheres import initial_spheres
from planning.kernel.coverings.outer_polytope import OuterPolytope
from planning.kernel.coverings.power_cells import power_cells
from planning.kernel.coverings.solid import Solid
from planning.kernel.shape import ShapeKind

# Permitted reach of the balls: a share of the shape's width between two bounds [m].
_RELATIVE_REACH, _MIN_REACH, _MAX_REACH = 0.04, 0.005, 0.010
# With more balls that reach less far, checks take longer: cases that few balls leave undecided are
# checked exactly, and quickly.
_MAX_NUM_BALLS = 8
_MIN_ROUNDS, _MAX_ROUNDS = 2, 4
# Least gain of a round beyond the minimum number; with less it is the last one.
_MIN_GAIN = 0.005
_STEPS = 8
_STENCIL = fibonacci_directions(18)
# If two centres are nearer than this share of the shape's size, one is removed.
_MIN_RELATIVE_SPACING = 1e-4


def outer_spheres(
    solid: Solid, polytope: OuterPolytope, choices: BallChoices
) -> tuple[Float64[np.ndarray, "n 4"], float]:
    """Return balls as rows (x, y, z, r), largest first, and their reach beyond the shape [m]."""
    target_reach = float(np.clip(_RELATIVE_REACH * solid.width, _MIN_REACH, _MAX_REACH))
    if solid.shape.kind is ShapeKind.CAPSULE:
        radius, half_length, _ = solid.shape.size
        balls, reach = capsule_spheres(radius, half_length, target_reach, _MAX_NUM_BALLS)
        balls[:, 3] += solid.rounding_margin
        return balls, reach + solid.rounding_margin
    min_spacing = _MIN_RELATIVE_SPACING * float((solid.high - solid.low).max())
    centers, reach = initial_spheres(choices, target_reach, _MAX_NUM_BALLS)
    best, best_reach = np.zeros((0, 4)), np.inf
    for round_ in range(_MAX_ROUNDS):
        centers = _without_close_centers(centers, min_spacing)
        balls = np.column_stack([centers, solid.depth(centers) + reach])
        cells = power_cells(polytope.v_representation, balls, solid.rounding_margin)
        nonempty = [i for i, cell in enumerate(cells) if len(cell)]
        cell_corners = _padded_cells([cells[i] for i in nonempty])
        centers = _optimized_centers(solid, cell_corners, centers[nonempty], choices.spacing / 2)
        radii = (
            _enclosing_radii(cell_corners, centers[:, None])[:, 0] * (1 + 1e-12)
            + solid.rounding_margin
        )
        reaches = radii - solid.depth(centers)
        reach = float(reaches.max())
        if reach <= best_reach:
            best = _without_redundant_balls(np.column_stack([centers, radii]), cell_corners)
        if round_ >= _MIN_ROUNDS and reach > best_reach * (1 - _MIN_GAIN):
            break
        best_reach = min(reach, best_reach)
    return best, max(0.0, float((best[:, 3] - solid.depth(best[:, :3])).max()))


def _without_close_centers(centers: Array, min_spacing: float) -> Float64[np.ndarray, "n 3"]:
    distances = np.linalg.norm(centers[:, None] - centers[None], axis=2)
    return centers[~np.tril(distances < min_spacing, -1).any(axis=1)]


def _without_redundant_balls(balls: Array, cell_corners: Array) -> Float64[np.ndarray, "n 4"]:
    """Return the balls, largest first, without those whose cells are inside larger balls."""
    balls = balls[np.argsort(-balls[:, 3], kind="stable")]
    all_centers = np.repeat(balls[None, :, :3], len(cell_corners), axis=0)
    is_contained = _enclosing_radii(cell_corners, all_centers) <= balls[:, 3]
    return balls[np.unique(np.argmax(is_contained, axis=1))]


def _padded_cells(cells: list[Array]) -> Float64[np.ndarray, "n k 3"]:
    """Return cells with equally many corners each, some repeated where there are fewer."""
    max_corners = max(len(cell) for cell in cells)
    return np.array([cell[np.arange(max_corners) % len(cell)] for cell in cells])


def _enclosing_radii(cell_corners: Array, centers: Array) -> Array:
    """Return the radii of balls about centers (n, m, 3) that contain their cells (n, k, 3)."""
    square = (centers**2).sum(axis=2)[:, :, None] + (cell_corners**2).sum(axis=2)[:, None]
    square -= 2 * np.einsum("nmi,nki->nmk", centers, cell_corners)
    return np.sqrt(np.maximum(square, 0.0).max(axis=2))


def _optimized_centers(solid: Solid, cell_corners: Array, centers: Array, step: float) -> Array:
    """Return the centers of least reach for the balls that contain their cells.

    The reach is convex, a farthest distance less a concave depth: a search by ever smaller steps in
    all directions ends near the minimum.
    """
    steps = np.full(len(centers), step)
    rows = np.arange(len(centers))
    for _ in range(_STEPS):
        trial_centers = centers[:, None] + steps[:, None, None] * np.vstack([np.zeros(3), _STENCIL])
        depths = solid.depth(trial_centers.reshape(-1, 3)).reshape(trial_centers.shape[:2])
        reaches = _enclosing_radii(cell_corners, trial_centers) - depths
        reaches[:, 1:][depths[:, 1:] < 0] = np.inf
        best = np.argmin(reaches, axis=1)
        centers = trial_centers[rows, best]
        steps = np.where(best == 0, steps / 2, steps)
    return centers
