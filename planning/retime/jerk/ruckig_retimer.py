"""Ruckig retimer: profiles under velocity, acceleration and jerk limits, on the path parameter.

Berscheid and Kroeger, "Jerk-limited real-time trajectory generation with arbitrary target states",
RSS 2021. The path is one degree of freedom, along which ruckig connects consecutive states: its
waypoint mode would call a service in the network and is never used. On a straight line that is
exact and time-optimal. On a curve, `speed_dp` chooses the parameters at which the acceleration is
zero, the speeds there, and bounds on sdot, sddot and sdddot that keep the limits in between; from
the resulting profile, `profile_optimizer` continues.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import ruckig

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.request.deadline import UNHURRIED, Deadline
from planning.domain.robot.joints import JointLimits
from planning.errors import RetimingFailed
from planning.retime.bounds import block_peaks
from planning.retime.cells import cut_at, even_edges, num_short, with_cuts
from planning.retime.compose import compose
from planning.retime.jerk.profile_optimizer import optimize_profile
from planning.retime.jerk.speed_dp import SpeedCells, SpeedSegment, solve_speed_dp
from planning.retime.limits.path_limit import PathLimit, PeakLimit, uses_of
from planning.retime.profile import SpeedProfile

# Number of cells of a smooth piece, and smallest number on each of its polynomial pieces.
_NUM_CELLS = 40
_LEAST_PER_PIECE = 2
# Longest cell for limits that change along a line (joint-space length).
_LONGEST = 0.1
# Cycle time [s], required by ruckig's constructor and used only in its online mode.
_CYCLE = 0.01
# Largest end error of ruckig, relative to the length of the speed segment.
_MISSED = 1e-6
_BRIEF = 1e-12
_DONE = {str(ruckig.Result.Working), str(ruckig.Result.Finished)}


def ruckig_profile(
    stretch: JointSpline,
    limits: JointLimits,
    path_limits: Sequence[PathLimit] = (),
    deadline: Deadline = UNHURRIED,
) -> SpeedProfile:
    """Return a rest-to-rest profile along a smooth piece, the fastest one if it is straight.

    Under path limits it is the fastest of several: one computed with the `PeakLimit`s among them,
    and others without any; all are slowed as a whole to keep all limits.

    Raises:
        RetimingFailed: No profile is found.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    cut, is_straight = _in_cells(stretch)
    plain = _planned(stretch, _cells(cut, limits), is_straight, deadline)
    found = (
        [plain]
        if is_straight.all()
        else [optimize_profile(stretch, plain, limits, deadline), plain]
    )
    if not path_limits:
        return found[0]
    among = path_limits, deadline
    slowed = [profile.duration * _slowing(stretch, profile, *among) for profile in found]
    known = [limit for limit in path_limits if isinstance(limit, PeakLimit)]
    if known and slowed[-1] > plain.duration:
        edges = with_cuts(cut.breaks, [limit.cuts(stretch) for limit in path_limits])
        short = cut_at(stretch, edges)
        short = cut_at(stretch, even_edges(edges, num_short(short, _LONGEST)))
        cells = _cells(short, limits, known)
        found.append(_planned(stretch, cells, np.zeros(short.num_pieces, dtype=bool), deadline))
        slowed.append(found[-1].duration * _slowing(stretch, found[-1], *among))
    return found[int(np.argmin(slowed))]


def _planned(
    stretch: JointSpline, cells: SpeedCells, is_straight: Any, deadline: Deadline
) -> SpeedProfile:
    """Return the fastest profile along cells, by dynamic programming and ruckig.

    Raises:
        RetimingFailed: No profile is found.
    """
    if is_straight.all() and stretch.num_pieces == 1:
        hops = [SpeedSegment(0, len(is_straight), (0.0, 0.0), _straight_bounds(cells, 0))]
    else:
        hops = _merged(solve_speed_dp(cells, deadline), cells, is_straight, stretch)
    if not hops:
        message = "no speed along the path keeps the jerk limits"
        raise RetimingFailed(message, {"method": "ruckig", "num_cells": len(is_straight)})
    whole = SpeedProfile.joined([_profile(hop, cells.edges) for hop in hops])
    return whole.split_at(stretch.breaks[1:-1])


def _slowing(
    stretch: JointSpline,
    profile: SpeedProfile,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> float:
    """Return the factor, at least 1, by which a profile must be slowed to keep path limits."""
    uses = uses_of(path_limits, compose(stretch, profile), deadline)
    return max([1.0, *(use.factor for _, use in uses)])


def _in_cells(stretch: JointSpline) -> tuple[JointSpline, Any]:
    """Return the smooth piece cut into cells, and whether each cell is straight."""
    widths = np.diff(stretch.breaks)
    counts = np.ceil(_NUM_CELLS * widths / widths.sum()).astype(int)
    counts = np.maximum(counts, _LEAST_PER_PIECE)
    pieces = np.repeat(np.arange(stretch.num_pieces), counts)
    cut = cut_at(stretch, even_edges(stretch.breaks, counts))
    return cut, ~stretch.coefficients[pieces, 2:].any(axis=(1, 2))


def _cells(cut: JointSpline, limits: JointLimits, known: Sequence[PeakLimit] = ()) -> SpeedCells:
    first, second, third = (block_peaks(cut, limits, order) for order in (1, 2, 3))
    bounds = limits.velocity, limits.acceleration, limits.jerk
    m1 = np.stack([first / bound for bound in bounds])
    m2 = np.stack([second / bound for bound in bounds[1:]])
    m3 = (third / limits.jerk)[None]
    if known:
        more = np.concatenate([limit.peaks(cut) for limit in known], axis=2)
        parts = zip((m1, m2, m3), np.split(more, [3, 5]), strict=True)
        m1, m2, m3 = (np.concatenate(both, axis=2) for both in parts)
    return SpeedCells(cut.breaks, m1, m2, m3)


def _straight_bounds(cells: SpeedCells, cell: int) -> tuple[float, float, float]:
    """Return V, A and J on a straight piece, from one of its cells."""
    v, a, j = (1 / float(cells.m1[n, cell].max()) for n in range(3))
    return v, a, j


def _merged(
    hops: list[SpeedSegment], cells: SpeedCells, is_straight: Any, stretch: JointSpline
) -> list[SpeedSegment]:
    """Return the segments with those on one straight piece merged: there ruckig is optimal."""
    pieces, _ = stretch.locate((cells.edges[:-1] + cells.edges[1:]) / 2)
    merged: list[SpeedSegment] = []
    for hop in hops:
        piece = pieces[hop.begin]
        alone = is_straight[hop.begin] and piece == pieces[hop.end - 1]
        if not alone:
            merged.append(hop)
            continue
        whole = SpeedSegment(hop.begin, hop.end, hop.speeds, _straight_bounds(cells, hop.begin))
        before = merged[-1] if merged else None
        if before is not None and is_straight[before.begin] and pieces[before.begin] == piece:
            whole = SpeedSegment(
                before.begin, hop.end, (before.speeds[0], hop.speeds[1]), whole.bounds
            )
            merged.pop()
        merged.append(whole)
    return merged


def _profile(hop: SpeedSegment, edges: Array) -> SpeedProfile:
    """Return ruckig's phases for a speed segment.

    Ruckig gets units with a top speed and a jerk of 1, for its absolute tolerances, and no more
    acceleration than it could use.
    """
    begin, end = float(edges[hop.begin]), float(edges[hop.end])
    top, acceleration, jerk = hop.bounds
    unit = np.sqrt(top / jerk)
    length = (end - begin) / (top * unit)
    phases = _state_to_state(
        length,
        (hop.speeds[0] / top, hop.speeds[1] / top),
        (1.0, min(acceleration * unit / top, 2.0), 1.0),
    )
    s, v, a = 0.0, hop.speeds[0] / top, 0.0
    rows: list[tuple[float, float, float, float, float]] = []
    for h, j in zip(phases.t, phases.j, strict=True):
        if h <= _BRIEF:
            continue
        rows.append((s, v, a, j, h))
        s += h * (v + h * (a / 2 + h * j / 6))
        v += h * (a + h * j / 2)
        a += h * j
    if abs(s - length) > _MISSED * length or phases.brake.duration > _BRIEF:
        message = "ruckig misses the end of a piece of path"
        raise RetimingFailed(message, {"method": "ruckig", "missed": s - length})
    columns = np.array(rows).T
    # The phases add up to the length up to rounding; the parameter is scaled to end exactly.
    scale = (end - begin) / s
    places = np.append(begin + columns[0] * scale, end)
    return SpeedProfile(
        places,
        columns[1] * scale / unit,
        columns[2] * scale / unit**2,
        columns[3] * scale / unit**3,
        columns[4] * unit,
    )


def _state_to_state(
    length: float, speeds: tuple[float, float], bounds: tuple[float, float, float]
) -> Any:
    """Return ruckig's profile from 0 to a length, with zero acceleration at both ends.

    Raises:
        RetimingFailed: Ruckig finds none.
    """
    generator = ruckig.Ruckig(1, _CYCLE)
    wanted = ruckig.InputParameter(1)
    wanted.current_position, wanted.target_position = [0.0], [length]
    wanted.current_velocity, wanted.target_velocity = [speeds[0]], [speeds[1]]
    wanted.max_velocity, wanted.max_acceleration, wanted.max_jerk = ([bound] for bound in bounds)
    trajectory = ruckig.Trajectory(1)
    try:
        result = str(generator.calculate(wanted, trajectory))
    except ruckig.RuckigError as fault:
        result = str(fault).strip().splitlines()[0]
    if result not in _DONE:
        message = f"ruckig answers {result}"
        raise RetimingFailed(message, {"method": "ruckig", "result": result})
    return trajectory.profiles[0][0]
