"""Path rows: acceleration limits along a path, as linear inequalities in x = sdot^2 and u = sddot.

With x at a cell's beginning and u constant on it, sdot^2 = x + 2 D u at a distance D into it,
where q'' = r' u + r'' (x + 2 D u). A scalar coordinate gives two inequalities. A block of several
has |q''| <= limit: q'' lies in the plane of r' and r'', in fact in the half of it with p >= 0 for
p = w (x + 2 D u), w = |r'' - (r'' . n) n|, n = r' / |r'|; there the disc is replaced by an
inscribed polygon, with one corner in the direction of r'.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.robot.joints import JointLimits
from planning.retime.smooth_pieces import path_derivatives

# Fractions of each cell at which limits are imposed. If r is quadratic, q'' is linear in D, and
# |q''| is largest at an end.
_PLACES = np.array([0.0, 0.5, 1.0])
_ENDS = np.array([0.0, 1.0])
# Sides of the half polygon; it lacks at most 1 - cos(pi / 24), 0.9 %, of the disc's radius.
_SIDES = 12
_ANGLES = (np.arange(_SIDES) + 0.5) * np.pi / _SIDES
_APOTHEM = np.cos(np.pi / (2 * _SIDES))


@dataclass(frozen=True)
class CellPlaces:
    """Parameters in the cells of a path at which limits are imposed.

    Attributes:
        cells: The path in cells.
        pieces: Index of the cell of each place, shape (n,): the first place of all cells, then the
            next.
        local: Path parameter since the beginning of the cell, shape (n,).
    """

    cells: JointSpline
    pieces: Any
    local: Array

    @classmethod
    def of(cls, cells: JointSpline) -> "CellPlaces":
        """Build with both ends and the middle of every cell; the ends alone if they suffice."""
        is_quadratic = cells.manifold.is_flat and not cells.coefficients[:, 3:].any()
        places = _ENDS if is_quadratic else _PLACES
        steps = np.diff(cells.breaks)
        pieces = np.tile(np.arange(len(steps)), len(places))
        return cls(cells, pieces, (places[:, None] * steps).ravel())

    @property
    def derivatives(self) -> tuple[Array, Array]:
        """Both derivatives of r, as Drake's v and vdot, each shape (n, nv)."""
        return path_derivatives(self.cells, self.pieces, self.local)

    def by_cell(self, ahead: Array, bend: Array) -> tuple[Array, Array]:
        """Return the rows of cells from rows ahead u + bend x(place) <= 1 of their places.

        With x at a cell's beginning, its value at a distance D is x + 2 D u.
        """
        count = len(self.local) // self.cells.num_pieces
        ahead = ahead + 2 * self.local[:, None] * bend
        return _side_by_side(ahead, count), _side_by_side(bend, count)


def acceleration_rows(cells: JointSpline, limits: JointLimits) -> tuple[Array, Array]:
    """Return a and b of a u + b x <= 1 on every cell, each shape (cells, rows).

    Blocks without motion have no rows.
    """
    places = CellPlaces.of(cells)
    rate, curvature = places.derivatives
    rows = _scalar_rows(rate, curvature, cells, limits) + _disc_rows(rate, curvature, cells, limits)
    if not rows:
        nothing = np.zeros((cells.num_pieces, 0))
        return nothing, nothing
    ahead = np.concatenate([row for row, _ in rows], axis=1)
    bend = np.concatenate([row for _, row in rows], axis=1)
    return places.by_cell(ahead, bend)


def _scalar_rows(
    rate: Array, curvature: Array, cells: JointSpline, limits: JointLimits
) -> list[tuple[Array, Array]]:
    """Return r' and r'' over the limits of moving blocks of one coordinate, both signs."""
    moves = cells.coefficients[:, 1:].any(axis=(0, 1))
    chosen = [i for i, block in enumerate(limits.blocks) if len(block) == 1 and moves[block[0]]]
    if not chosen:
        return []
    indices = [limits.blocks[i][0] for i in chosen]
    bounds = limits.acceleration[chosen]
    ahead, bend = rate[:, indices] / bounds, curvature[:, indices] / bounds
    return [(ahead, bend), (-ahead, -bend)]


def _disc_rows(
    rate: Array, curvature: Array, cells: JointSpline, limits: JointLimits
) -> list[tuple[Array, Array]]:
    """Return the sides of the polygons of moving blocks of several coordinates."""
    rows: list[tuple[Array, Array]] = []
    cosines, sines = np.cos(_ANGLES), np.sin(_ANGLES)
    for block, limit in zip(limits.blocks, limits.acceleration, strict=True):
        indices = list(block)
        if len(indices) > 1 and cells.coefficients[:, 1:, indices].any():
            ahead, straight, across = _in_plane(rate[:, indices], curvature[:, indices])
            radius = limit * _APOTHEM
            rows.append((cosines * ahead / radius, (cosines * straight + sines * across) / radius))
    return rows


def _in_plane(rate: Array, curvature: Array) -> tuple[Array, Array, Array]:
    """Return |r'|, and r'' along it and across it, each shape (n, 1)."""
    ahead = np.linalg.norm(rate, axis=1, keepdims=True)
    unit = rate / np.maximum(ahead, 1e-300)
    straight = np.sum(curvature * unit, axis=1, keepdims=True)
    across = np.linalg.norm(curvature - straight * unit, axis=1, keepdims=True)
    return ahead, straight, across


def _side_by_side(rows: Array, num_places: int) -> Array:
    """Return the rows of all places of a cell in one row."""
    by_place = rows.reshape(num_places, -1, rows.shape[1])
    return by_place.transpose(1, 0, 2).reshape(by_place.shape[1], -1)
