"""Acceleration limits along a path, as linear inequalities in x = sdot^2 and u = sddot.

With x at an interval's beginning and u constant on it, sdot^2 = x + 2 D u at a distance D into it,
where q'' = r' u + r'' (x + 2 D u). A scalar coordinate gives two inequalities. A block of several
has |q''| <= limit: q'' lies in the plane of r' and r'', in fact in the half of it with p >= 0 for
p = w (x + 2 D u), w = |r'' - (r'' . n) n|, n = r' / |r'|; there the disc is replaced by a polygon
with corners on it, one of them for motion straight ahead.
"""

from typing import Any

import numpy as np

from planning.domain.curve import JointSpline
from planning.domain.joints import JointLimits
from planning.retime.stretches import path_derivatives

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Where in each grid interval the limits are demanded.
_PLACES = (0.0, 0.5, 1.0)
# Sides of the half polygon; it lacks at most 1 - cos(pi / 24), 0.9 %, of the disc's radius.
_SIDES = 12
_ANGLES = (np.arange(_SIDES) + 0.5) * np.pi / _SIDES
_APOTHEM = np.cos(np.pi / (2 * _SIDES))


def acceleration_rows(
    stretch: JointSpline, limits: JointLimits, grid: Array
) -> tuple[Array, Array]:
    """Return a and b of a u + b x <= 1 on every grid interval, each shape (intervals, rows).

    Blocks that nowhere move have no rows.
    """
    steps = np.diff(grid)
    pieces, _ = stretch.locate((grid[:-1] + grid[1:]) / 2)
    rows_a: list[Array] = []
    rows_b: list[Array] = []
    moves = (stretch.coefficients[:, 1:] != 0).any(axis=(0, 1))
    for place in _PLACES:
        local = grid[:-1] + place * steps - stretch.breaks[pieces]
        rate, curvature = path_derivatives(stretch, pieces, local)
        twice = (2 * place * steps)[:, None]
        for block, limit in zip(limits.blocks, limits.acceleration, strict=True):
            indices = [i for i in block if moves[i]]
            if len(indices) == 1:
                straight, across = curvature[:, indices], np.zeros((len(steps), 1))
                ahead = rate[:, indices]
                cosines, sines, radius = np.array([1.0, -1.0]), np.zeros(2), limit
            elif indices:
                ahead, straight, across = _in_plane(rate[:, list(block)], curvature[:, list(block)])
                cosines, sines, radius = np.cos(_ANGLES), np.sin(_ANGLES), limit * _APOTHEM
            else:
                continue
            bend = (cosines * straight + sines * across) / radius
            rows_a.append(cosines * ahead / radius + twice * bend)
            rows_b.append(bend)
    return np.concatenate(rows_a, axis=1), np.concatenate(rows_b, axis=1)


def _in_plane(rate: Array, curvature: Array) -> tuple[Array, Array, Array]:
    """Return |r'|, and r'' along it and across it, each shape (n, 1)."""
    ahead = np.linalg.norm(rate, axis=1, keepdims=True)
    unit = rate / np.maximum(ahead, 1e-300)
    straight = np.sum(curvature * unit, axis=1, keepdims=True)
    across = np.linalg.norm(curvature - straight * unit, axis=1, keepdims=True)
    return ahead, straight, across
