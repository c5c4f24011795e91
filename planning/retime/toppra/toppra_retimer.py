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
from planning.domain.request.deadline import UNHURRIED, Deadline
from planning.domain.robot.joints import JointLimits
from planning.errors import RetimingFailed
from planning.retime.bounds import block_sizes
from planning.retime.cells import cut_at, even_edges, num_short, ways, with_cuts
from planning.retime.compose import shifted
from planning.retime.jerk.velocity_bounds import speed_caps
from planning.retime.limits.path_limit import PathLimit, rows_of
from planning.retime.line_profile import LineLimits, profile_between
from planning.retime.polynomials import norms
from planning.retime.profile import SpeedProfile
from planning.retime.toppra.path_rows import acceleration_rows
from planning.retime.toppra.toppra_passes import squared_speeds

# Smallest number of cells of a curve, additional ones per radian of turn, and the largest number.
_LEAST, _PER_TURN, _MOST = 2, 6, 64
# Factor on the number of cells where nothing is a line, as every cell costs some time. Durations
# are within 0.15 % of those with many more cells, on strongly curved paths within 2 %.
_FINER = 2
# Longest cell for limits that change along a line (joint-space length), and smallest number of
# cells.
_LONGEST, _LEAST_CELLS = 0.06, 32
# Refinement of cells in which the acceleration should jump: number of parts, share of the duration
# at which it stops, and number of rounds.
_SPLIT, _COST, _ROUNDS = 4, 3e-4, 3
# Squared speed that stands for no bound, in toppra's units of order one.
_UNBOUNDED = 1e6
# Smallest row that counts as a limit.
_LEAST_ROW = 1e-300
# Smallest r' of a cell relative to the largest; smaller values are replaced by it.
_STANDSTILL = 1e-9


def toppra_profile(
    stretch: JointSpline,
    limits: JointLimits,
    path_limits: Sequence[PathLimit] = (),
    deadline: Deadline = UNHURRIED,
) -> SpeedProfile:
    """Return the fastest rest-to-rest profile along a smooth piece.

    Raises:
        RetimingFailed: toppra finds none, or a path limit does not allow rest.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    is_line = ~stretch.coefficients[:, 2:].any(axis=(1, 2))
    if all(limit.is_uniform for limit in path_limits):
        cells, owners = _in_cells(stretch, is_line, 1 if is_line.any() else _FINER)
        return _profile(cells, is_line[owners], limits, path_limits, deadline)
    cells, _ = _in_cells(stretch, np.zeros_like(is_line), 1)
    edges = _short_edges(stretch, cells, path_limits)
    profile = _curved_profile(cut_at(stretch, edges), limits, path_limits, deadline)
    for _ in range(_ROUNDS):
        sharper = _sharper_edges(profile)
        if len(sharper) == len(profile.s):
            break
        profile = _curved_profile(cut_at(stretch, sharper), limits, path_limits, deadline)
    return profile


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
    sizes = block_sizes(cells, limits, 1)
    peaks = sizes.max(axis=1)
    peaks = np.maximum(peaks, _STANDSTILL * peaks.max())
    with np.errstate(divide="ignore"):
        speed = (limits.velocity / peaks).min(axis=1)
        acceleration = (limits.acceleration / peaks).min(axis=1)
    others = rows_of(path_limits, cells, deadline)
    lines = LineLimits(is_line, speed, *_line_pushes(acceleration, others))
    if cells.num_pieces == 1 and is_line[0]:
        return profile_between(cells.breaks, np.zeros(2), lines)
    # In units of the duration at the velocity limits, toppra's numbers are of order one, as its
    # absolute tolerances require.
    unit = float((np.diff(cells.breaks) / speed).sum())
    caps = _at_edges(speed_caps(sizes, limits.velocity) * unit**2)
    a, b = acceleration_rows(cells, limits)
    for limit, more in zip(path_limits, others, strict=True):
        caps = np.minimum(caps, _at_edges(limit.caps(cells) * unit**2))
        a, b = (np.concatenate(both, axis=1) for both in zip((a, b), more, strict=True))
    deadline.check("retime")
    x = squared_speeds(cells.breaks, (a / unit**2, b / unit**2), caps) / unit**2
    if not (lines.is_line | (x[:-1] + x[1:] > 0)).all():
        message = "toppra's profile stands still on the way"
        raise RetimingFailed(message, {"method": "toppra", "num_grid_points": len(x)})
    return profile_between(cells.breaks, x, lines)


def _line_pushes(acceleration: Array, rows: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Return the largest d2s/dt2 and -d2s/dt2 on cells that are lines, where all b are zero."""
    up = down = acceleration
    for a, _ in rows:
        most = np.maximum(a.max(axis=1, initial=0.0), _LEAST_ROW)
        least = np.maximum(-a.min(axis=1, initial=0.0), _LEAST_ROW)
        up, down = np.minimum(up, 1 / most), np.minimum(down, 1 / least)
    return up, down


def _at_edges(caps: Array) -> Array:
    """Return the smaller bound of both adjacent cells at each edge."""
    return np.minimum(np.append(caps[:, 0], _UNBOUNDED), np.insert(caps[:, 1], 0, _UNBOUNDED))


def _short_edges(
    stretch: JointSpline, cells: JointSpline, path_limits: Sequence[PathLimit]
) -> Array:
    """Return edges of cells with little change of limits inside, and jumps only at edges."""
    longest = min(_LONGEST, float(ways(cells).sum()) / _LEAST_CELLS)
    edges = even_edges(cells.breaks, num_short(cells, longest))
    return with_cuts(edges, [limit.cuts(stretch) for limit in path_limits])


def _sharper_edges(profile: SpeedProfile) -> Array:
    """Return the edges with additional ones where the acceleration jumps inside a cell.

    Squared speeds are linear on cells: with a jump D of their slope inside one of width w, the
    optimal x is larger by up to w D / 4; the lost time is that over x^1.5 times w / 2.
    """
    widths, pushes = np.diff(profile.s), profile.a
    jumps = np.abs(np.diff(2 * pushes))
    jump = np.maximum(np.append(jumps, 0.0), np.insert(jumps, 0, 0.0))
    squared = (widths / profile.h) ** 2
    cost = np.minimum(widths * jump / 4, squared) / squared**1.5 * widths / 2
    counts = np.where(cost > _COST * profile.duration, _SPLIT, 1)
    return even_edges(profile.s, counts)


def _in_cells(stretch: JointSpline, is_line: Any, finer: int) -> tuple[JointSpline, Any]:
    """Return the smooth piece cut into cells, and the piece of each cell."""
    counts = np.where(is_line, 1, finer * _num_cells(stretch))
    widths = np.diff(stretch.breaks)
    owners = np.repeat(np.arange(len(counts)), counts)
    firsts = np.cumsum(counts) - counts
    offsets = (np.arange(len(owners)) - firsts[owners]) * (widths / counts)[owners]
    edges = np.append(stretch.breaks[owners] + offsets, stretch.breaks[-1])
    local = shifted(stretch.coefficients[owners], offsets)
    return JointSpline(stretch.joints, edges, stretch.bases[owners], local), owners


def _num_cells(stretch: JointSpline) -> Any:
    """Return the number of cells of each curved piece, more for larger changes of direction."""
    degrees = np.arange(stretch.coefficients.shape[1])
    if len(degrees) < 3:
        return np.ones(stretch.num_pieces, dtype=int)
    widths = np.diff(stretch.breaks)
    # Bounds on the change of r' along a piece, over the greatest |r'| anywhere.
    changes = norms(stretch.coefficients) * widths[:, None] ** (degrees - 1)
    fastest = norms(stretch.coefficients[:, 1]).max()
    turns = (changes * degrees)[:, 2:].sum(axis=1) / fastest
    return np.minimum(np.ceil(_LEAST + _PER_TURN * turns), _MOST).astype(int)
