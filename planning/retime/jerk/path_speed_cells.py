"""Speed cells of a path: cells, and bounds on the path's derivatives on each, for `speed_dp`."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from planning.domain.curves.curve import JointSpline
from planning.domain.robot.joints import JointLimits
from planning.kernel.native import native
from planning.retime.block_peaks import block_peaks
from planning.retime.cells import cut_at, even_edges
from planning.retime.jerk.profile_optimizer import can_optimize
from planning.retime.jerk.speed_dp import SpeedCells
from planning.retime.limits.path_limit import PeakLimit

# Smallest number of cells on each polynomial piece.
_MIN_CELLS_PER_PIECE = 2


def speed_cells_of(
    smooth_piece: JointSpline, limits: JointLimits, num_cells: int
) -> tuple[SpeedCells, Any]:
    """Return about `num_cells` cells of a smooth piece, and whether each is straight."""
    module = native()
    has_slope = smooth_piece.coefficients.shape[1] > 1
    if module is None or not has_slope or not can_optimize(smooth_piece, limits):
        return cells_in_numpy(smooth_piece, limits, num_cells)
    return _kernel_cells(module, smooth_piece, limits, num_cells)


def _kernel_cells(
    module: Any, smooth_piece: JointSpline, limits: JointLimits, num_cells: int
) -> tuple[SpeedCells, Any]:
    """Return cells of a smooth piece by the kernel, and whether each is straight."""
    bounds = np.stack([limits.velocity, limits.acceleration, limits.jerk])
    path = smooth_piece.breaks, smooth_piece.coefficients
    edges, pieces, peaks = module.speed_cells(path, bounds, num_cells, _MIN_CELLS_PER_PIECE)
    is_straight = ~smooth_piece.coefficients[:, 2:].any(axis=(1, 2))
    return SpeedCells(edges, peaks[:3], peaks[3:5], peaks[5:]), is_straight[pieces]


def cells_in_numpy(
    smooth_piece: JointSpline, limits: JointLimits, num_cells: int
) -> tuple[SpeedCells, Any]:
    """Return the same for all joints, without the kernel."""
    cut, is_straight = _cut_into_cells(smooth_piece, num_cells)
    return bounded_cells(cut, limits), is_straight


def _cut_into_cells(smooth_piece: JointSpline, num_cells: int) -> tuple[JointSpline, Any]:
    """Return the smooth piece cut into cells, and whether each cell is straight."""
    widths = np.diff(smooth_piece.breaks)
    counts = np.ceil(num_cells * widths / widths.sum()).astype(int)
    counts = np.maximum(counts, _MIN_CELLS_PER_PIECE)
    pieces = np.repeat(np.arange(smooth_piece.num_pieces), counts)
    cut = cut_at(smooth_piece, even_edges(smooth_piece.breaks, counts))
    return cut, ~smooth_piece.coefficients[pieces, 2:].any(axis=(1, 2))


def bounded_cells(
    cut: JointSpline, limits: JointLimits, peak_limits: Sequence[PeakLimit] = ()
) -> SpeedCells:
    """Return the bounds on cells of a path, those of further limits included."""
    first, second, third = (block_peaks(cut, limits, order) for order in (1, 2, 3))
    bounds = limits.velocity, limits.acceleration, limits.jerk
    m1 = np.stack([first / bound for bound in bounds])
    m2 = np.stack([second / bound for bound in bounds[1:]])
    m3 = (third / limits.jerk)[None]
    if peak_limits:
        more = np.concatenate([limit.peaks(cut) for limit in peak_limits], axis=2)
        parts = zip((m1, m2, m3), np.split(more, [3, 5]), strict=True)
        m1, m2, m3 = (np.concatenate(both, axis=2) for both in parts)
    return SpeedCells(cut.breaks, m1, m2, m3)
