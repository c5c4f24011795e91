"""TOPP-RA retimer: time-optimal profiles under velocity and acceleration limits.

Only the speeds at the edges of cells are taken from toppra. A curve is cut into cells on which s(t)
has constant acceleration. A line is one cell: its limits are constant along it, so that toppra need
only find speeds at both ends that one acceleration can connect; the fastest motion in between has a
closed form (`line_profile`). q(t) = r(s(t)) is composed exactly: the motion never leaves the path.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.request.deadline import NO_DEADLINE, Deadline
from planning.domain.robot.joints import JointLimits
from planning.errors import RetimingFailed
from planning.retime.block_peaks import bernstein_block_norms
from planning.retime.cells import (
    cut_at,
    even_edges,
    num_parts,
    piece_length_bounds,
    with_extra_edges,
)
from planning.retime.compose import taylor_shifted
from planning.retime.jerk.velocity_bounds import cell_velocity_bounds
from planning.retime.limits.path_limit import PathLimit, path_limit_rows
from planning.retime.line_profile import LineLimits, profile_between
from planning.retime.polynomials import norms
from planning.retime.profile import SpeedProfile
from planning.retime.toppra.path_rows import acceleration_rows
from planning.retime.toppra.toppra_passes import squared_speeds

# Smallest number of cells of a curve, additional ones per radian of turn, and the largest number.
_MIN_CELLS, _CELLS_PER_RADIAN, _MAX_CELLS = 2, 6, 64
# Factor on the number of cells where nothing is a line, as every cell costs some time. Durations
# are within 0.15 % of those with many more cells, on strongly curved paths within 2 %.
_CURVED_FACTOR = 2
# Longest cell for limits that change along a line (joint-space length), and smallest number of
# cells.
_MAX_CELL_LENGTH, _MIN_PATH_CELLS = 0.06, 32
# Refinement of cells in which the acceleration should jump: number of parts, share of the duration
# at which it stops, and number of rounds.
_NUM_PARTS, _MAX_TIME_LOSS, _MAX_ROUNDS = 4, 3e-4, 3
# Squared speed that stands for no bound, in toppra's units of order one.
_UNBOUNDED = 1e6
# Smallest row that counts as a limit.
_MIN_COEFFICIENT = 1e-300
# Smallest r' of a cell relative to the largest; smaller values are replaced by it.
_MIN_RELATIVE_RATE = 1e-9


def toppra_profile(
    smooth_piece: JointSpline,
    limits: JointLimits,
    path_limits: Sequence[PathLimit] = (),
    deadline: Deadline = NO_DEADLINE,
) -> SpeedProfile:
    """Return the fastest rest-to-rest profile along a smooth piece.

    Raises:
        RetimingFailed: toppra finds none, or a path limit does not allow rest.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    is_line = ~smooth_piece.coefficients[:, 2:].any(axis=(1, 2))
    if all(limit.is_uniform for limit in path_limits):
        cells, pieces = _cut_into_cells(
            smooth_piece, is_line, 1 if is_line.any() else _CURVED_FACTOR
        )
        return _profile(cells, is_line[pieces], limits, path_limits, deadline)
    cells, _ = _cut_into_cells(smooth_piece, np.zeros_like(is_line), 1)
    edges = _refined_edges(smooth_piece, cells, path_limits)
    profile = _curved_profile(cut_at(smooth_piece, edges), limits, path_limits, deadline)
    for _ in range(_MAX_ROUNDS):
        refined_edges = _edges_split_at_jumps(profile)
        if len(refined_edges) == len(profile.s):
            break
        profile = _curved_profile(
            cut_at(smooth_piece, refined_edges), limits, path_limits, deadline
        )
    return profile


def _require_motion(lines: LineLimits, x: Array) -> None:
    """Require that no curved cell has zero speed at both ends.

    Raises:
        RetimingFailed: One has.
    """
    if not (lines.is_line | (x[:-1] + x[1:] > 0)).all():
        message = "toppra's profile has zero path velocity between start and goal"
        raise RetimingFailed(message, {"method": "toppra", "num_grid_points": len(x)})


def _curved_profile(
    cells: JointSpline,
    limits: JointLimits,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> SpeedProfile:
    return _profile(cells, np.zeros(cells.num_pieces, dtype=bool), limits, path_limits, deadline)


def _profile(
    cells: JointSpline,
    is_line: Any,
    limits: JointLimits,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> SpeedProfile:
    """Return the fastest profile with constant acceleration on all cells but lines.

    Raises:
        RetimingFailed: As `toppra_profile`.
    """
    sizes = bernstein_block_norms(cells, limits, 1)
    peaks = sizes.max(axis=1)
    peaks = np.maximum(peaks, _MIN_RELATIVE_RATE * peaks.max())
    with np.errstate(divide="ignore"):
        speed = (limits.velocity / peaks).min(axis=1)
        acceleration = (limits.acceleration / peaks).min(axis=1)
    path_rows = path_limit_rows(path_limits, cells, deadline)
    lines = LineLimits(is_line, speed, *_line_accelerations(acceleration, path_rows))
    if cells.num_pieces == 1 and is_line[0]:
        return profile_between(cells.breaks, np.zeros(2), lines)
    # In units of the duration at the velocity limits, toppra's numbers are of order one, as its
    # absolute tolerances require.
    time_unit = float((np.diff(cells.breaks) / speed).sum())
    unit = time_unit * time_unit
    caps = _bounds_at_edges(cell_velocity_bounds(sizes, limits.velocity) * unit)
    a, b = acceleration_rows(cells, limits)
    for limit, limit_rows in zip(path_limits, path_rows, strict=True):
        caps = np.minimum(caps, _bounds_at_edges(limit.path_velocity_bounds(cells) * unit))
        a, b = (np.concatenate(both, axis=1) for both in zip((a, b), limit_rows, strict=True))
    deadline.check("retime")
    x = squared_speeds(cells.breaks, (a / unit, b / unit), caps) / unit
    _require_motion(lines, x)
    return profile_between(cells.breaks, x, lines)


def _line_accelerations(
    acceleration: Array, rows: list[tuple[Array, Array]]
) -> tuple[Array, Array]:
    """Return the largest d2s/dt2 and -d2s/dt2 on cells that are lines, where all b are zero."""
    up = down = acceleration
    for a, _ in rows:
        up = np.minimum(up, 1 / np.maximum(a.max(axis=1, initial=0.0), _MIN_COEFFICIENT))
        down = np.minimum(down, 1 / np.maximum(-a.min(axis=1, initial=0.0), _MIN_COEFFICIENT))
    return up, down


def _bounds_at_edges(bounds: Array) -> Array:
    """Return the smaller bound of both adjacent cells at each edge."""
    return np.minimum(np.append(bounds[:, 0], _UNBOUNDED), np.insert(bounds[:, 1], 0, _UNBOUNDED))


def _refined_edges(
    smooth_piece: JointSpline, cells: JointSpline, path_limits: Sequence[PathLimit]
) -> Array:
    """Return edges of cells with little change of limits inside, and jumps only at edges."""
    max_length = min(_MAX_CELL_LENGTH, float(piece_length_bounds(cells).sum()) / _MIN_PATH_CELLS)
    edges = even_edges(cells.breaks, num_parts(cells, max_length))
    return with_extra_edges(edges, [limit.discontinuities(smooth_piece) for limit in path_limits])


def _edges_split_at_jumps(profile: SpeedProfile) -> Array:
    """Return the edges with additional ones where the acceleration jumps inside a cell.

    Squared speeds are linear on cells: with a jump D of their slope inside one of width w, the
    optimal x is larger by up to w D / 4; the lost time is that over x^1.5 times w / 2.
    """
    widths, accelerations = np.diff(profile.s), profile.a
    jumps = np.abs(np.diff(2 * accelerations))
    jump = np.maximum(np.append(jumps, 0.0), np.insert(jumps, 0, 0.0))
    squared = (widths / profile.h) ** 2
    cost = np.minimum(widths * jump / 4, squared) / squared**1.5 * widths / 2
    counts = np.where(cost > _MAX_TIME_LOSS * profile.duration, _NUM_PARTS, 1)
    return even_edges(profile.s, counts)


def _cut_into_cells(
    smooth_piece: JointSpline, is_line: Any, factor: int
) -> tuple[JointSpline, Any]:
    """Return the smooth piece cut into cells, and the piece of each cell."""
    counts = np.where(is_line, 1, factor * _num_cells(smooth_piece))
    widths = np.diff(smooth_piece.breaks)
    pieces = np.repeat(np.arange(len(counts)), counts)
    firsts = np.cumsum(counts) - counts
    offsets = (np.arange(len(pieces)) - firsts[pieces]) * (widths / counts)[pieces]
    edges = np.append(smooth_piece.breaks[pieces] + offsets, smooth_piece.breaks[-1])
    local = taylor_shifted(smooth_piece.coefficients[pieces], offsets)
    return JointSpline(smooth_piece.joints, edges, smooth_piece.bases[pieces], local), pieces


def _num_cells(smooth_piece: JointSpline) -> Any:
    """Return the number of cells of each curved piece, more for larger changes of direction."""
    degrees = np.arange(smooth_piece.coefficients.shape[1])
    if len(degrees) < 3:
        return np.ones(smooth_piece.num_pieces, dtype=int)
    widths = np.diff(smooth_piece.breaks)
    # Bounds on the change of r' along a piece, over the greatest |r'| anywhere.
    changes = norms(smooth_piece.coefficients) * widths[:, None] ** (degrees - 1)
    max_rate = norms(smooth_piece.coefficients[:, 1]).max()
    direction_changes = (changes * degrees)[:, 2:].sum(axis=1) / max_rate
    return np.minimum(
        np.ceil(_MIN_CELLS + _CELLS_PER_RADIAN * direction_changes), _MAX_CELLS
    ).astype(int)
