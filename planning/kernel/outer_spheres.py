"""Outer spheres: few balls that contain a convex shape and reach little beyond it.

The shape, or a polytope around it, is cut into convex pieces; a ball that contains a piece's
corners contains the piece, so the balls of all pieces contain the shape. A ball of radius r about a
point of depth d (its distance from the surface) reaches at most r - d beyond the shape: shrunk
about that point by d / r it lies inside. So a piece at the surface gets a ball from deep within: of
several points on the way inwards the one whose ball reaches least. The piece whose ball reaches
farthest is cut next, across its longest side, until none reaches too far or there are enough; balls
that others make needless are left out (Chvatal, "A greedy heuristic for the set-covering problem",
1979).
"""

from heapq import heappop, heappush
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.kernel.pieces import Piece
from planning.kernel.solid import Solid

type Array = np.ndarray[Any, np.dtype[np.float64]]

# How far balls may reach: a share of the shape's width between two bounds [m].
_SHARE, _LEAST, _MOST = 0.06, 0.005, 0.010
_MOST_PIECES = 16
_STEPS = 12
# Shares of the way from a piece's middle to the shape's deepest point.
_INWARDS = np.array([0.0, 0.05, 0.1, 0.17, 0.25, 0.35, 0.5, 0.7, 0.9])
# For rounding in corners that were computed, and in what is computed with the balls [m].
_DUST = 2e-7


def outer_spheres(solid: Solid) -> tuple[Float64[np.ndarray, "n 4"], float]:
    """Return balls as rows (x, y, z, r), largest first, and how far they reach beyond the shape."""
    aim = float(np.clip(_SHARE * solid.width, _LEAST, _MOST))
    heap: list[tuple[float, int, Array, Piece]] = []
    _push(heap, solid, solid.polytope, 0)
    number = 0
    while -heap[0][0] > aim and len(heap) < _MOST_PIECES:
        _, _, _, piece = heappop(heap)
        low, high = piece.low, piece.high
        axis = int(np.argmax(high - low))
        for half in piece.cut(axis, float(low[axis] + high[axis]) / 2):
            number += 1
            _push(heap, solid, half, number)
    pieces = sorted(heap, key=lambda item: item[1])
    balls = _needed([ball for _, _, ball, _ in pieces], [piece.corners for *_, piece in pieces])
    balls = balls[np.argsort(-balls[:, 3], kind="stable")]
    return balls, max(0.0, -heap[0][0])


def _push(
    heap: list[tuple[float, int, Array, Piece]], solid: Solid, piece: Piece, number: int
) -> None:
    middle = _middle(piece.corners)
    centers = middle + _INWARDS[:, None] * (solid.deepest - middle)
    away = piece.corners[None] - centers[:, None]
    radii = np.sqrt(np.einsum("cpi,cpi->cp", away, away).max(axis=1)) * (1 + 1e-9) + _DUST
    reaches = radii - solid.depth(centers)
    best = int(np.argmin(reaches))
    heappush(heap, (-float(reaches[best]), number, np.append(centers[best], radii[best]), piece))


def _middle(points: Array) -> Array:
    """Return the middle of a nearly smallest ball about points.

    Badoiu and Clarkson, "Smaller core-sets for balls", 2003: steps towards the farthest point.
    """
    center = (points.min(axis=0) + points.max(axis=0)) / 2
    for step in range(3, _STEPS):
        far = points[np.argmax(((points - center) ** 2).sum(axis=1))]
        center = center + (far - center) / step
    return center


def _needed(balls: list[Array], pieces: list[Array]) -> Array:
    """Return as few of the balls as greed finds to contain every piece."""
    corners = np.concatenate(pieces)
    starts = np.cumsum([0, *(len(piece) for piece in pieces[:-1])])
    spheres = np.array(balls)
    away = corners[None] - spheres[:, None, :3]
    farthest = np.maximum.reduceat(np.einsum("bpi,bpi->bp", away, away), starts, axis=1)
    held = farthest <= (spheres[:, 3:] - _DUST / 2) ** 2
    left = np.ones(len(pieces), dtype=bool)
    taken: list[int] = []
    while left.any():
        taken.append(int(np.argmax(held[:, left].sum(axis=1))))
        left &= ~held[taken[-1]]
    return spheres[taken]
