"""Outer spheres: few balls that contain a convex shape and reach little beyond it.

A ball of radius r about a point of depth d (its distance from the surface) reaches r - d beyond a
convex shape: shrunk about that point by d / r it lies inside. A polytope around the shape is
partitioned among balls (power cells), and each centre moves to where the ball about its own cell
reaches least, again and again: Lloyd's algorithm, for the farthest reach instead of the mean
square. The cells cover the polytope, so the balls contain the shape from any initial centres.
"""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.kernel.coverings.ball_choices import BallChoices, directions
from planning.kernel.coverings.capsule_spheres import capsule_spheres
from planning.kernel.coverings.initial_spheres import initial_spheres
from planning.kernel.coverings.outer_polytope import OuterPolytope
from planning.kernel.coverings.power_cells import power_cells
from planning.kernel.coverings.solid import Solid
from planning.kernel.shape import ShapeKind

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Permitted reach of the balls: a share of the shape's width between two bounds [m].
_SHARE, _LEAST, _MOST = 0.04, 0.005, 0.010
# With more balls that reach less far, checks take longer: cases that few balls leave undecided are
# checked exactly, and quickly.
_MOST_BALLS = 8
_LEAST_ROUNDS, _ROUNDS = 2, 4
# Least gain of a round beyond the minimum number; with less it is the last one.
_GAIN = 0.005
_STEPS = 8
_STENCIL = directions(18)
# If two centres are nearer than this share of the shape's size, one is removed.
_CLOSEST = 1e-4


def outer_spheres(
    solid: Solid, polytope: OuterPolytope, choices: BallChoices
) -> tuple[Float64[np.ndarray, "n 4"], float]:
    """Return balls as rows (x, y, z, r), largest first, and their reach beyond the shape [m]."""
    aim = float(np.clip(_SHARE * solid.width, _LEAST, _MOST))
    if solid.shape.kind is ShapeKind.CAPSULE:
        radius, half_length, _ = solid.shape.size
        balls, reach = capsule_spheres(radius, half_length, aim, _MOST_BALLS)
        balls[:, 3] += solid.rounding_margin
        return balls, reach + solid.rounding_margin
    closest = _CLOSEST * float((solid.high - solid.low).max())
    centers, reach = initial_spheres(choices, aim, _MOST_BALLS)
    best, least = np.zeros((0, 4)), np.inf
    for round_ in range(_ROUNDS):
        centers = _apart(centers, closest)
        balls = np.column_stack([centers, solid.depth(centers) + reach])
        cells = power_cells(polytope.piece, balls, solid.rounding_margin)
        kept = [i for i, cell in enumerate(cells) if len(cell)]
        shares = _stacked([cells[i] for i in kept])
        centers = _moved(solid, shares, centers[kept], choices.spacing / 2)
        radii = _radii(shares, centers[:, None])[:, 0] * (1 + 1e-12) + solid.rounding_margin
        reaches = radii - solid.depth(centers)
        reach = float(reaches.max())
        if reach <= least:
            best = _needed(np.column_stack([centers, radii]), shares)
        if round_ >= _LEAST_ROUNDS and reach > least * (1 - _GAIN):
            break
        least = min(reach, least)
    return best, max(0.0, float((best[:, 3] - solid.depth(best[:, :3])).max()))


def _apart(centers: Array, closest: float) -> Float64[np.ndarray, "n 3"]:
    away = np.linalg.norm(centers[:, None] - centers[None], axis=2)
    return centers[~np.tril(away < closest, -1).any(axis=1)]


def _needed(balls: Array, shares: Array) -> Float64[np.ndarray, "n 4"]:
    """Return the balls, largest first, without those whose cells are inside larger balls."""
    balls = balls[np.argsort(-balls[:, 3], kind="stable")]
    everywhere = np.repeat(balls[None, :, :3], len(shares), axis=0)
    held = _radii(shares, everywhere) <= balls[:, 3]
    return balls[np.unique(np.argmax(held, axis=1))]


def _stacked(cells: list[Array]) -> Float64[np.ndarray, "n k 3"]:
    """Return cells with equally many corners each, some repeated where there are fewer."""
    most = max(len(cell) for cell in cells)
    return np.array([cell[np.arange(most) % len(cell)] for cell in cells])


def _radii(shares: Array, centers: Array) -> Array:
    """Return the radii of balls about centers (n, m, 3) that contain their cells (n, k, 3)."""
    square = (centers**2).sum(axis=2)[:, :, None] + (shares**2).sum(axis=2)[:, None]
    square -= 2 * np.einsum("nmi,nki->nmk", centers, shares)
    return np.sqrt(np.maximum(square, 0.0).max(axis=2))


def _moved(solid: Solid, shares: Array, centers: Array, step: float) -> Array:
    """Return the centers of least reach for the balls that contain their cells.

    The reach is convex, a farthest distance less a concave depth: a search by ever smaller steps in
    all directions ends near the minimum.
    """
    steps = np.full(len(centers), step)
    rows = np.arange(len(centers))
    for _ in range(_STEPS):
        tried = centers[:, None] + steps[:, None, None] * np.vstack([np.zeros(3), _STENCIL])
        depths = solid.depth(tried.reshape(-1, 3)).reshape(tried.shape[:2])
        reaches = _radii(shares, tried) - depths
        reaches[:, 1:][depths[:, 1:] < 0] = np.inf
        best = np.argmin(reaches, axis=1)
        centers = tried[rows, best]
        steps = np.where(best == 0, steps / 2, steps)
    return centers
