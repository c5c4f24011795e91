"""Ruckig retimer: profiles under velocity, acceleration and jerk limits, on the path parameter.

Berscheid and Kroeger, "Jerk-limited real-time trajectory generation with arbitrary target states",
RSS 2021. The path is one degree of freedom, along which ruckig connects consecutive states: its
waypoint mode would call a service in the network and is never used. On a straight line that is
exact and time-optimal. On a curve, `speed_dp` chooses the parameters at which the acceleration is
zero, the speeds there, and bounds on sdot, sddot and sdddot that keep the limits in between; from
the resulting profile, `profile_optimizer` continues. Where it can, a coarse choice does.
"""

import math
from collections.abc import Sequence
from itertools import chain
from typing import Any

import numpy as np
import ruckig

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.request.deadline import NO_DEADLINE, Deadline
from planning.domain.robot.joints import JointLimits
from planning.errors import RetimingFailed
from planning.retime.block_peaks import block_norms
from planning.retime.cells import cut_at, even_edges, num_parts, with_extra_edges
from planning.retime.compose import compose
from planning.retime.jerk.path_speed_cells import bounded_cells, speed_cells_of
from planning.retime.jerk.profile_optimizer import can_optimize, optimize_profile
from planning.retime.jerk.speed_dp import (
    COARSE,
    FINE,
    SpeedCells,
    SpeedLevels,
    SpeedSegment,
    solve_speed_dp,
)
from planning.retime.limits.path_limit import PathLimit, PeakLimit, path_limit_utilizations
from planning.retime.profile import SpeedProfile

# Number of cells of a smooth piece, and that of one whose profile is optimized.
_NUM_CELLS, _NUM_COARSE_CELLS = 40, 16
# Longest cell for limits that change along a line (joint-space length).
_MAX_CELL_LENGTH = 0.1
# Cycle time [s], required by ruckig's constructor and used only in its online mode.
_CYCLE_TIME = 0.01
# Largest end error of ruckig, relative to the length of the speed segment.
_MAX_END_ERROR = 1e-6
_MIN_PHASE = 1e-12
_SUCCESS_RESULTS = {str(ruckig.Result.Working), str(ruckig.Result.Finished)}


def ruckig_profile(
    smooth_piece: JointSpline,
    limits: JointLimits,
    path_limits: Sequence[PathLimit] = (),
    deadline: Deadline = NO_DEADLINE,
) -> SpeedProfile:
    """Return a rest-to-rest profile along a smooth piece, the fastest one if it is straight.

    Under path limits it is the fastest of several: one computed with the `PeakLimit`s among them,
    and others without any; all are slowed as a whole to keep all limits.

    Raises:
        RetimingFailed: No profile is found.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    is_straight = not smooth_piece.coefficients[:, 2:].any()
    if not path_limits and is_straight and smooth_piece.num_pieces == 1:
        return _line_profile(smooth_piece, limits)
    if not path_limits and not is_straight and can_optimize(smooth_piece, limits):
        cells = _NUM_COARSE_CELLS, COARSE
        initial, _ = _dp_profile_of(smooth_piece, limits, cells, deadline)
        optimized = optimize_profile(smooth_piece, initial, limits, deadline)
        if not np.array_equal(optimized.s, initial.s):
            return optimized
    initial, cell_edges = _dp_profile_of(smooth_piece, limits, (_NUM_CELLS, FINE), deadline)
    if is_straight:
        profiles = [initial]
    else:
        profiles = [optimize_profile(smooth_piece, initial, limits, deadline), initial]
    if not path_limits:
        return profiles[0]
    limits_and_deadline = path_limits, deadline
    slowed_durations = [
        profile.duration * _required_time_scaling(smooth_piece, profile, *limits_and_deadline)
        for profile in profiles
    ]
    peak_limits = [limit for limit in path_limits if isinstance(limit, PeakLimit)]
    if peak_limits and slowed_durations[-1] > initial.duration:
        edges = with_extra_edges(
            cell_edges, [limit.discontinuities(smooth_piece) for limit in path_limits]
        )
        short_cells = cut_at(smooth_piece, edges)
        short_cells = cut_at(
            smooth_piece, even_edges(edges, num_parts(short_cells, _MAX_CELL_LENGTH))
        )
        speed_cells = bounded_cells(short_cells, limits, peak_limits)
        profiles.append(
            _dp_profile(
                smooth_piece,
                speed_cells,
                np.zeros(short_cells.num_pieces, dtype=bool),
                FINE,
                deadline,
            )
        )
        slowed_durations.append(
            profiles[-1].duration
            * _required_time_scaling(smooth_piece, profiles[-1], *limits_and_deadline)
        )
    return profiles[int(np.argmin(slowed_durations))]


def _line_profile(line: JointSpline, limits: JointLimits) -> SpeedProfile:
    """Return the fastest profile along one straight piece.

    Raises:
        RetimingFailed: No profile is found.
    """
    rates = block_norms(line.coefficients[0, 1], limits)
    v, a, j = (
        1 / float((rates / bound).max())
        for bound in (limits.velocity, limits.acceleration, limits.jerk)
    )
    return _profile_of([SpeedSegment(0, 1, (0.0, 0.0), (v, a, j))], line.breaks)


def _dp_profile_of(
    smooth_piece: JointSpline,
    limits: JointLimits,
    cells: tuple[int, SpeedLevels],
    deadline: Deadline,
) -> tuple[SpeedProfile, Array]:
    """Return the fastest profile along some cells, and their edges.

    Args:
        smooth_piece: The path.
        limits: Limits of velocity, acceleration and jerk.
        cells: Number of cells, and speeds to choose from.
        deadline: Time limit.

    Raises:
        RetimingFailed: No profile is found.
    """
    num_cells, levels = cells
    speed_cells, is_straight = speed_cells_of(smooth_piece, limits, num_cells)
    profile = _dp_profile(smooth_piece, speed_cells, is_straight, levels, deadline)
    return profile, speed_cells.edges


def _dp_profile(
    smooth_piece: JointSpline,
    cells: SpeedCells,
    is_straight: Any,
    levels: SpeedLevels,
    deadline: Deadline,
) -> SpeedProfile:
    """Return the fastest profile along cells, by dynamic programming and ruckig.

    Raises:
        RetimingFailed: No profile is found.
    """
    segments = _merge_straight_segments(
        solve_speed_dp(cells, deadline, levels=levels), cells, is_straight, smooth_piece
    )
    if not segments:
        message = "no velocity profile along the path satisfies the jerk limits"
        raise RetimingFailed(message, {"method": "ruckig", "num_cells": len(is_straight)})
    return _profile_of(segments, cells.edges).split_at(smooth_piece.breaks[1:-1])


def _profile_of(segments: list[SpeedSegment], edges: Array) -> SpeedProfile:
    """Return the profile of consecutive segments between edges, by ruckig.

    Raises:
        RetimingFailed: Ruckig finds none.
    """
    parts = [_phases_of(segment, edges) for segment in segments]
    s, v, a, j, h = (np.array(column) for column in zip(*chain.from_iterable(parts), strict=True))
    return SpeedProfile(np.append(s, edges[segments[-1].end]), v, a, j, h)


def _required_time_scaling(
    smooth_piece: JointSpline,
    profile: SpeedProfile,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> float:
    """Return the factor, at least 1, by which a profile must be slowed to keep path limits."""
    utilizations = path_limit_utilizations(path_limits, compose(smooth_piece, profile), deadline)
    return max([1.0, *(utilization.time_scaling for _, utilization in utilizations)])


def _straight_bounds(cells: SpeedCells, cell: int) -> tuple[float, float, float]:
    """Return V, A and J on a straight piece, from one of its cells."""
    v, a, j = (1 / float(cells.m1[n, cell].max()) for n in range(3))
    return v, a, j


def _merge_straight_segments(
    segments: list[SpeedSegment], cells: SpeedCells, is_straight: Any, smooth_piece: JointSpline
) -> list[SpeedSegment]:
    """Return the segments with those on one straight piece merged: there ruckig is optimal."""
    pieces, _ = smooth_piece.locate((cells.edges[:-1] + cells.edges[1:]) / 2)
    merged: list[SpeedSegment] = []
    for segment in segments:
        piece = pieces[segment.begin]
        is_on_straight_piece = is_straight[segment.begin] and piece == pieces[segment.end - 1]
        if not is_on_straight_piece:
            merged.append(segment)
            continue
        joined = SpeedSegment(
            segment.begin, segment.end, segment.speeds, _straight_bounds(cells, segment.begin)
        )
        previous = merged[-1] if merged else None
        if previous is not None and is_straight[previous.begin] and pieces[previous.begin] == piece:
            joined = SpeedSegment(
                previous.begin, segment.end, (previous.speeds[0], segment.speeds[1]), joined.bounds
            )
            merged.pop()
        merged.append(joined)
    return merged


def _phases_of(
    segment: SpeedSegment, edges: Array
) -> list[tuple[float, float, float, float, float]]:
    """Return ruckig's phases for a speed segment: s, v, a and j at the start of each, and h.

    Ruckig gets units with a top speed and a jerk of 1, for its absolute tolerances, and no more
    acceleration than it could use.
    """
    begin, end = float(edges[segment.begin]), float(edges[segment.end])
    max_speed, acceleration, jerk = segment.bounds
    unit = math.sqrt(max_speed / jerk)
    length = (end - begin) / (max_speed * unit)
    phases = _solve_ruckig(
        length,
        (segment.speeds[0] / max_speed, segment.speeds[1] / max_speed),
        (1.0, min(acceleration * unit / max_speed, 2.0), 1.0),
    )
    s, v, a = 0.0, segment.speeds[0] / max_speed, 0.0
    rows: list[tuple[float, float, float, float, float]] = []
    for h, j in zip(phases.t, phases.j, strict=True):
        if h <= _MIN_PHASE:
            continue
        rows.append((s, v, a, j, h))
        s += h * (v + h * (a / 2 + h * j / 6))
        v += h * (a + h * j / 2)
        a += h * j
    if abs(s - length) > _MAX_END_ERROR * length or phases.brake.duration > _MIN_PHASE:
        message = "ruckig's profile does not end at the end of its path segment"
        raise RetimingFailed(message, {"method": "ruckig", "missed": s - length})
    # The phases add up to the length up to rounding; the parameter is scaled to end exactly.
    scale = (end - begin) / s
    return [
        (begin + s * scale, v * scale / unit, a * scale / unit**2, j * scale / unit**3, h * unit)
        for s, v, a, j, h in rows
    ]


def _solve_ruckig(
    length: float, speeds: tuple[float, float], bounds: tuple[float, float, float]
) -> Any:
    """Return ruckig's profile from 0 to a length, with zero acceleration at both ends.

    Raises:
        RetimingFailed: Ruckig finds none.
    """
    generator = ruckig.Ruckig(1, _CYCLE_TIME)
    ruckig_input = ruckig.InputParameter(1)
    ruckig_input.current_position, ruckig_input.target_position = [0.0], [length]
    ruckig_input.current_velocity, ruckig_input.target_velocity = [speeds[0]], [speeds[1]]
    ruckig_input.max_velocity, ruckig_input.max_acceleration, ruckig_input.max_jerk = (
        [bound] for bound in bounds
    )
    trajectory = ruckig.Trajectory(1)
    try:
        result = str(generator.calculate(ruckig_input, trajectory))
    except ruckig.RuckigError as fault:
        result = str(fault).strip().splitlines()[0]
    if result not in _SUCCESS_RESULTS:
        message = f"ruckig failed with {result}"
        raise RetimingFailed(message, {"method": "ruckig", "result": result})
    return trajectory.profiles[0][0]
