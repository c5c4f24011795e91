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
_SAMPLE_FRACTIONS = np.array([0.0, 0.5, 1.0])
_END_FRACTIONS = np.array([0.0, 1.0])
# Sides of the half polygon; it lacks at most 1 - cos(pi / 24), 0.9 %, of the disc's radius.
_NUM_SIDES = 12
_ANGLES = (np.arange(_NUM_SIDES) + 0.5) * np.pi / _NUM_SIDES
_APOTHEM = np.cos(np.pi / (2 * _NUM_SIDES))


@dataclass(frozen=True)
class CellSamples:
    """Parameters in the cells of a path at which limits are imposed.

    Attributes:
        cells: The path in cells.
        pieces: Index of the cell of each sample, shape (n,): the first sample of all cells, then
            the next.
        local: Path parameter since the beginning of the cell, shape (n,).
    """

    cells: JointSpline
    pieces: Any
    local: Array

    @classmethod
    def of(cls, cells: JointSpline) -> "CellSamples":
        """Build with both ends and the middle of every cell; the ends alone if they suffice."""
        is_quadratic = cells.manifold.is_flat and not cells.coefficients[:, 3:].any()
        fractions = _END_FRACTIONS if is_quadratic else _SAMPLE_FRACTIONS
        steps = np.diff(cells.breaks)
        pieces = np.tile(np.arange(len(steps)), len(fractions))
        return cls(cells, pieces, (fractions[:, None] * steps).ravel())

    @property
    def derivatives(self) -> tuple[Array, Array]:
        """Both derivatives of r, as Drake's v and vdot, each shape (n, nv)."""
        return path_derivatives(self.cells, self.pieces, self.local)

    def rows_by_cell(self, a: Array, b: Array) -> tuple[Array, Array]:
        """Return the rows of cells from rows a u + b x <= 1 at their samples.

        With x at a cell's beginning, sdot^2 at a distance D into it is x + 2 D u.
        """
        count = len(self.local) // self.cells.num_pieces
        a = a + 2 * self.local[:, None] * b
        return _cell_rows(a, count), _cell_rows(b, count)


def acceleration_rows(cells: JointSpline, limits: JointLimits) -> tuple[Array, Array]:
    """Return a and b of a u + b x <= 1 on every cell, each shape (cells, rows).

    Blocks without motion have no rows.
    """
    samples = CellSamples.of(cells)
    rate, curvature = samples.derivatives
    rows = _scalar_rows(rate, curvature, cells, limits) + _disc_rows(rate, curvature, cells, limits)
    if not rows:
        no_rows = np.zeros((cells.num_pieces, 0))
        return no_rows, no_rows
    a = np.concatenate([row for row, _ in rows], axis=1)
    b = np.concatenate([row for _, row in rows], axis=1)
    return samples.rows_by_cell(a, b)


def _scalar_rows(
    rate: Array, curvature: Array, cells: JointSpline, limits: JointLimits
) -> list[tuple[Array, Array]]:
    """Return r' and r'' over the limits of moving blocks of one coordinate, both signs."""
    is_moving = cells.coefficients[:, 1:].any(axis=(0, 1))
    chosen = [i for i, block in enumerate(limits.blocks) if len(block) == 1 and is_moving[block[0]]]
    if not chosen:
        return []
    indices = [limits.blocks[i][0] for i in chosen]
    bounds = limits.acceleration[chosen]
    a, b = rate[:, indices] / bounds, curvature[:, indices] / bounds
    return [(a, b), (-a, -b)]


def _disc_rows(
    rate: Array, curvature: Array, cells: JointSpline, limits: JointLimits
) -> list[tuple[Array, Array]]:
    """Return the sides of the polygons of moving blocks of several coordinates."""
    rows: list[tuple[Array, Array]] = []
    cosines, sines = np.cos(_ANGLES), np.sin(_ANGLES)
    for block, limit in zip(limits.blocks, limits.acceleration, strict=True):
        indices = list(block)
        if len(indices) > 1 and cells.coefficients[:, 1:, indices].any():
            length, along, across = _curvature_components(rate[:, indices], curvature[:, indices])
            radius = limit * _APOTHEM
            rows.append((cosines * length / radius, (cosines * along + sines * across) / radius))
    return rows


def _curvature_components(rate: Array, curvature: Array) -> tuple[Array, Array, Array]:
    """Return |r'|, and r'' along it and across it, each shape (n, 1)."""
    tangent_length = np.linalg.norm(rate, axis=1, keepdims=True)
    unit = rate / np.maximum(tangent_length, 1e-300)
    along = np.sum(curvature * unit, axis=1, keepdims=True)
    across = np.linalg.norm(curvature - along * unit, axis=1, keepdims=True)
    return tangent_length, along, across


def _cell_rows(rows: Array, num_samples: int) -> Array:
    """Return the rows of all samples of a cell side by side, shape (cells, samples * rows)."""
    by_sample = rows.reshape(num_samples, -1, rows.shape[1])
    return by_sample.transpose(1, 0, 2).reshape(by_sample.shape[1], -1)
