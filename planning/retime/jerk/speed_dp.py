"""Speed dynamic programming: speeds along a path under jerk limits, at points of zero acceleration.

The path is cut into cells. With M_n >= |r^(n)| on the cells in between, bounds V, A, J on sdot,
sddot and sdddot keep every limit if

    M_1 V <= v,   M_1 A + M_2 V^2 <= a,   M_1 J + 3 M_2 V A + M_3 V^3 <= j

(the chain rule). A speed segment connects two cell boundaries with given speeds and zero
acceleration at both, as fast as such bounds allow, and cruises at the greater speed for the
remaining length; its duration has a closed form. The fastest chain of segments over a few speeds at
every boundary is found by dynamic programming.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.request.deadline import NO_DEADLINE, Deadline
from planning.kernel.native import native

# Factors for slower candidates, where the path is too short to reach any of these.
_SLOWDOWN_FACTORS = 0.1 ** np.arange(4.0)
_FINE_FACTORS = np.geomspace(0.84, 1.19, 9)
# Shares of the remaining jerk for 3 M_2 V A; the rest is for J.
_JERK_SHARES = np.array([0.5, 0.15])
# Largest number of cells of a speed segment.
_MAX_SEGMENT_CELLS = 24
# Largest number of boundaries at which segments begin and end; of more cells some are skipped.
_MAX_NODES = 320
# Number of segments timed at once, which fits a cache.
_CHUNK_SIZE = 1024
_LENGTH_FACTOR = 1 - 1e-9
# Relative difference up to which times count as equal: rounding does not decide between one long
# segment and several short ones.
_EQUAL_TIMES = 1e-12
# Speeds are whole powers of one plus this, so that two of them are equal or clearly different:
# segments between almost equal speeds would have phases too short for polynomials in double
# precision.
_SPEED_QUANTUM = 1e-3


@dataclass(frozen=True)
class SpeedLevels:
    """Candidate speeds at every cell boundary.

    Attributes:
        factors: Speeds relative to the greatest possible there, shape (k,).
        num_refinements: How often the program is solved again, with speeds near the chosen ones.
    """

    factors: Array
    num_refinements: int


FINE = SpeedLevels(0.8 ** np.arange(11.0), 2)
# For a profile that is only where an optimizer begins.
COARSE = SpeedLevels(0.64 ** np.arange(6.0), 0)


@dataclass(frozen=True)
class SpeedCells:
    """Derivative bounds of a path on cells, relative to limits.

    Attributes:
        edges: Path parameter at the boundaries, shape (n + 1,).
        m1: M_1 over the limits of velocity, acceleration and jerk, shape (3, n, blocks).
        m2: M_2 over the limits of acceleration and jerk, shape (2, n, blocks).
        m3: M_3 over the limit of jerk, shape (1, n, blocks).
    """

    edges: Array
    m1: Array
    m2: Array
    m3: Array

    def top_speeds(self) -> Array:
        """Return the largest constant path speed on each cell, shape (n,)."""
        with np.errstate(divide="ignore"):
            fastest = np.minimum(1 / self.m1[0], 1 / np.sqrt(self.m2[0]))
            fastest = np.minimum(fastest, 1 / np.cbrt(self.m3[0]))
        return fastest.min(axis=1)


@dataclass(frozen=True)
class SpeedSegment:
    """A transition between two cell boundaries, with zero acceleration at both.

    Attributes:
        begin: Index of the boundary.
        end: Index of the boundary, greater.
        speeds: Path speeds at both.
        bounds: V, A and J in between.
    """

    begin: int
    end: int
    speeds: tuple[float, float]
    bounds: tuple[float, float, float]


def solve_speed_dp(
    cells: SpeedCells,
    deadline: Deadline = NO_DEADLINE,
    *,
    levels: SpeedLevels = FINE,
    use_kernel: bool = True,
) -> list[SpeedSegment]:
    """Return the fastest chain of speed segments from rest to rest; empty if there is none.

    Args:
        cells: Cells of the path.
        deadline: Time limit.
        levels: Speeds to choose from.
        use_kernel: Whether to use the native kernel where there is one.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    top_speeds = cells.top_speeds()
    max_speeds = np.minimum(np.append(top_speeds, np.inf), np.insert(top_speeds, 0, np.inf))
    nodes = np.arange(0, len(top_speeds), -(-len(top_speeds) // _MAX_NODES))
    nodes = np.append(nodes, len(top_speeds))
    segments: list[SpeedSegment] = []
    for factor in _SLOWDOWN_FACTORS:
        if not segments:
            speeds = np.asarray(factor * max_speeds[nodes, None] * levels.factors, dtype=np.float64)
            segments = _fastest_chain(cells, nodes, speeds, deadline, use_kernel=use_kernel)
    for _ in range(levels.num_refinements):
        if not segments:
            return segments
        nodes = np.array([segment.begin for segment in segments] + [segments[-1].end])
        chosen_speeds = np.array([segment.speeds[0] for segment in segments] + [0.0])
        speeds = np.minimum(chosen_speeds[:, None] * _FINE_FACTORS, max_speeds[nodes, None])
        segments = _fastest_chain(cells, nodes, speeds, deadline, use_kernel=use_kernel)
    return segments


def _fastest_chain(
    cells: SpeedCells, nodes: Any, speeds: Array, deadline: Deadline, *, use_kernel: bool
) -> list[SpeedSegment]:
    """Return the fastest chain over the given nodes with the given speeds, shape (nodes, k)."""
    speeds = (1 + _SPEED_QUANTUM) ** np.floor(
        np.log(np.maximum(speeds, 1e-300)) / np.log1p(_SPEED_QUANTUM)
    )
    speeds[[0, -1]] = 0.0
    module: Any = native() if use_kernel else None
    if module is not None and np.isfinite(speeds).all():
        deadline.check("retime")
        return _fastest_chain_by_kernel(module, cells, nodes, speeds)
    begins, ends = _node_pairs(len(nodes))
    peaks = _peaks_between(cells, nodes, begins, ends)
    lengths = cells.edges[nodes[ends]] - cells.edges[nodes[begins]]
    chunks = [slice(i, i + _CHUNK_SIZE) for i in range(0, len(begins), _CHUNK_SIZE)]
    timed: list[tuple[Array, Any]] = []
    for rows in chunks:
        deadline.check("retime")
        end_speeds = speeds[begins[rows]], speeds[ends[rows]]
        timed.append(_segment_durations(peaks[:, :, rows], lengths[rows], *end_speeds))
    times, jerk_shares = (np.concatenate([part[i] for part in timed]) for i in range(2))
    count = speeds.shape[1]
    best = np.full((len(nodes), count), np.inf)
    best[0, 0] = 0.0
    predecessors: dict[int, Any] = {}
    rows_of = np.split(np.arange(len(ends)), np.flatnonzero(np.diff(ends)) + 1)
    for rows in rows_of:
        end = int(ends[rows[0]])
        totals = (best[begins[rows]][:, :, None] + times[rows]).reshape(-1, count)
        best[end] = totals.min(axis=0)
        predecessors[end] = (rows, np.argmax(totals <= best[end] * (1 + _EQUAL_TIMES), axis=0))
    if not np.isfinite(best[-1, 0]):
        return []
    segments: list[SpeedSegment] = []
    end, level = len(nodes) - 1, 0
    while end > 0:
        rows, choice = predecessors[end]
        row, before = rows[choice[level] // count], int(choice[level] % count)
        begin = int(begins[row])
        pair = float(speeds[begin, before]), float(speeds[end, level])
        jerk_share = _JERK_SHARES[int(jerk_shares[row, before, level])]
        a, j = _bounds(peaks[:, :, row : row + 1], np.array([[max(pair)]]), jerk_share)
        bounds = max(pair), float(a[0, 0]), float(j[0, 0])
        segments.append(SpeedSegment(int(nodes[begin]), int(nodes[end]), pair, bounds))
        end, level = begin, before
    return segments[::-1]


def _fastest_chain_by_kernel(
    module: Any, cells: SpeedCells, nodes: Any, speeds: Array
) -> list[SpeedSegment]:
    between = np.maximum.reduceat(
        np.concatenate([cells.m1, cells.m2, cells.m3]), nodes[:-1], axis=1
    )
    begins, ends, before, after, bounds = module.fastest_chain(
        cells.edges[nodes] * _LENGTH_FACTOR, between, speeds, _JERK_SHARES, _MAX_SEGMENT_CELLS
    )
    rows = zip(
        nodes[begins].tolist(),
        nodes[ends].tolist(),
        zip(before.tolist(), after.tolist(), strict=True),
        map(tuple, bounds.tolist()),
        strict=True,
    )
    return [SpeedSegment(*row) for row in rows]


def _node_pairs(num_nodes: int) -> tuple[Any, Any]:
    """Return both node indices of every candidate segment, ordered by end."""
    begins, ends = np.meshgrid(np.arange(num_nodes), np.arange(num_nodes))
    is_candidate = (ends > begins) & (ends - begins <= _MAX_SEGMENT_CELLS)
    return begins[is_candidate], ends[is_candidate]


def _peaks_between(cells: SpeedCells, nodes: Any, begins: Any, ends: Any) -> Array:
    """Return the largest of each m between two nodes, shape (6, blocks, pairs)."""
    stacked = np.concatenate([cells.m1, cells.m2, cells.m3]).transpose(1, 0, 2)
    between = np.maximum.reduceat(stacked, nodes[:-1], axis=0)
    table = np.zeros((min(_MAX_SEGMENT_CELLS, len(between)), len(between), *stacked.shape[1:]))
    table[0] = between
    for more in range(1, len(table)):
        table[more, :-more] = np.maximum(table[more - 1, :-more], between[more:])
    return np.ascontiguousarray(table[ends - begins - 1, begins].transpose(1, 2, 0))


def _bounds(peaks: Array, speeds: Array, jerk_share: float) -> tuple[Array, Array]:
    """Return A and J at top speeds, shapes (pairs, k); not positive where there are none."""
    m1v, m1a, m1j, m2a, m2j, m3j = peaks[:, :, :, None]
    tiny = 1e-300
    v, v2, v3 = speeds, speeds**2, speeds**3
    left = 1 - m3j * v3
    acceleration = np.minimum(
        ((1 - m2a * v2) / np.maximum(m1a, tiny)).min(axis=0),
        jerk_share * (left / np.maximum(3 * m2j * v, tiny)).min(axis=0),
    )
    jerk = ((left - 3 * m2j * (v * acceleration)) / np.maximum(m1j, tiny)).min(axis=0)
    is_slow = m1v.max(axis=0) * v <= 1 + 1e-12
    return np.where(is_slow, acceleration, -1.0), np.where(is_slow, jerk, -1.0)


def _segment_durations(
    peaks: Array, lengths: Array, before: Array, after: Array
) -> tuple[Array, Any]:
    """Return the duration of every segment, infinite if impossible, and the share that gives it."""
    v0, v1 = before[:, :, None], after[:, None, :]
    is_braking = v0 >= v1
    max_speeds, speed_changes = np.where(is_braking, v0, v1), np.abs(v1 - v0)
    usable_lengths = lengths[:, None, None] * _LENGTH_FACTOR
    best = np.full(max_speeds.shape, np.inf)
    best_shares = np.zeros(max_speeds.shape, dtype=np.int8)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse, mean = 1 / max_speeds, (v0 + v1) / 2
        for i, jerk_share in enumerate(_JERK_SHARES):
            at_before, at_after = (_bounds(peaks, speeds, jerk_share) for speeds in (before, after))
            a, j = (
                np.where(is_braking, at_before[n][:, :, None], at_after[n][:, None, :])
                for n in range(2)
            )
            # Triangular or trapezoidal acceleration profile.
            ramp = np.where(
                speed_changes * j < a * a, 2 * np.sqrt(speed_changes / j), speed_changes / a + a / j
            )
            cruise_lengths = usable_lengths - mean * ramp
            is_feasible = (a > 0) & (j > 0) & (cruise_lengths >= 0)
            time = np.where(is_feasible, ramp + cruise_lengths * inverse, np.inf)
            time[np.isnan(time)] = np.inf
            best_shares[time < best] = i
            np.minimum(best, time, out=best)
    return best, best_shares
