r"""Stops along the path of a trajectory: from every instant, within limits, as short as possible.

A trajectory q(t) followed at t = s(clock) from s' = 1 to s' = 0 stays on its path, so it is as
collision-free as the trajectory is. With y = s'^2, x = -s'' and, on a cell, constant x,

    vdot = q''(s) y - q'(s) x,        y falls by 2 x for every second of s.

**Acceleration limits.** On a cell of width h the condition |q'' y - q' x| <= a is imposed at both
of its values of y, y_0 and y_0 - 2 x h, for every Bernstein coefficient: it then holds on the whole
cell, being convex in (q', q'') and affine in y. Each is a quadratic inequality in x; where the
motion comes to rest within the cell, y = 0 takes the place of the second. Where bounds differ by
sign, the condition is |q'' y - q' x - m| <= a, about their middle m. The largest x that satisfies
all of them is taken, or x = 0 (the trajectory's own acceleration times y <= 1, which is proven to
be within limits). So each stop brakes as hard as its cells allow. Accelerations of frames and
torques are more conditions of that form, a `StopConstraint` each. Torques contain gravity, which
does not depend on s': where the static load exceeds a joint's limit no stop may end, and
there may be no admissible x. Stops that reach such an instant must begin later.

**Jerk limits.** Then s'' must not jump, and stops are of one form: s' = 1 - 3 u^2 + 2 u^3 with
u = clock / T. On each cell s', s'' and s''' lie in known intervals, as do q', q'' and q''', and

    vddot = q''' s'^3 + 3 q'' s' s'' + q' s'''

and vdot are bounded by interval arithmetic. The smallest T that passes, from a list, is taken.

A stop may be delayed: from an instant within a cell the motion continues unchanged until the next
stop begins, and further if there is none there; under jerk limits until the stop that ends first.
Finishing the motion is a stop as well, so there always is one.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64, Int

from planning.certify.intervals.motion_cells import MotionCells
from planning.certify.joints.limit_checks import MAX_UTILIZATION
from planning.certify.stopping.stop_constraint import interval_product
from planning.domain.arrays import Array, Indices
from planning.domain.request.deadline import NO_DEADLINE, Deadline

# Squared path velocities below this are rest.
_REST_TOLERANCE = 1e-12
# Squared size of a coefficient of x that counts as zero: it has no effect even at _MAX_BRAKING.
_ZERO_SQUARED_SIZE = 1e-200
# Range of braking x: stops that end within a cell are above the first, all useful ones below the
# second [1/s].
_MIN_BRAKING, _MAX_BRAKING = 1e-12, 1e9
# Durations of stops under jerk limits: shortest [s], and ratio of consecutive ones.
_MIN_DURATION, _DURATION_RATIO = 0.01, 1.15
# Table of the profile's integral, and the error of a lookup.
_PROFILE_TABLE = np.linspace(0.0, 1.0, 4097)
_TABLE_ERROR = 1e-3


@dataclass(frozen=True)
class Stops:
    """Stops from the beginning of each cell, and from the end.

    Attributes:
        times: Time until rest [s], shape (n + 1,).
        ends: Index of the first cell not entered, shape (n + 1,).
    """

    times: Float64[np.ndarray, " n_plus_1"]
    ends: Int[np.ndarray, " n_plus_1"]


def hardest_stops(cells: MotionCells, deadline: Deadline = NO_DEADLINE) -> Stops:
    """Return stops under acceleration limits, each as hard as its cells allow.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    count = len(cells.begins)
    ends = np.arange(count + 1)
    times, y = np.zeros(count + 1), np.append(np.ones(count), 0.0)
    moving = np.arange(count)
    while len(moving):
        deadline.check("certify")
        cell, before = ends[moving], y[moving]
        width = cells.widths[cell]
        braking = max_braking(cells, cell, before)
        after = before - 2 * width * braking
        after[after < _REST_TOLERANCE] = 0.0
        # Coming to rest within the cell takes s' / x.
        traversed = np.where(after > 0, width, before / (2 * np.maximum(braking, _MIN_BRAKING)))
        times[moving] += 2 * traversed / (np.sqrt(before) + np.sqrt(after))
        y[moving] = after
        ends[moving] += 1
        moving = moving[(after > 0) & (ends[moving] < count)]
    return _end_if_sooner(cells, *_with_delays(cells, times, ends))


def _with_delays(cells: MotionCells, times: Array, ends: Indices) -> tuple[Array, Indices]:
    """Return stops with those that do not exist replaced by the next one, after a delay."""
    for i in range(len(cells.begins) - 1, -1, -1):
        if np.isnan(times[i]):
            times[i], ends[i] = cells.widths[i] + times[i + 1], ends[i + 1]
    return times, ends


def smooth_stops(cells: MotionCells, deadline: Deadline = NO_DEADLINE) -> Stops:
    """Return stops under acceleration and jerk limits, by one profile, with the best delay.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    count, durations = len(cells.begins), smooth_durations(cells, deadline)
    end_times = np.append(cells.begins + durations, cells.end)
    # Of all stops that begin here or later, the one that ends first.
    soonest = np.arange(count + 1)
    for i in range(count - 1, -1, -1):
        soonest[i] = i if end_times[i] < end_times[soonest[i + 1]] else soonest[i + 1]
    edges = np.append(cells.begins, cells.end)
    # The profile's integral is T / 2.
    stop_times = edges[soonest] + np.append(durations, 0.0)[soonest] / 2
    ends = np.searchsorted(edges, np.minimum(stop_times, cells.end) - 1e-12)
    return _end_if_sooner(cells, end_times[soonest] - edges, np.maximum(ends, np.arange(count + 1)))


def smooth_durations(
    cells: MotionCells, deadline: Deadline = NO_DEADLINE
) -> Float64[np.ndarray, " n"]:
    """Return durations of smooth stops that begin with each cell [s], infinite if none passes."""
    durations = np.full(len(cells.begins), np.inf)
    duration = _MIN_DURATION
    while duration < 2 * cells.end:
        undecided = np.flatnonzero(np.isinf(durations))
        durations[undecided[_can_stop(cells, undecided, duration, deadline)]] = duration
        duration *= _DURATION_RATIO
    return durations


def _end_if_sooner(cells: MotionCells, times: Array, ends: Indices) -> Stops:
    """Return the stops, replaced by the end of the motion where that is sooner."""
    remaining = cells.end - np.append(cells.begins, cells.end)
    is_sooner = remaining < times
    return Stops(
        np.where(is_sooner, remaining, times), np.where(is_sooner, len(cells.begins), ends)
    )


def max_braking(cells: MotionCells, cell: Indices, y: Array) -> Array:
    """Return the hardest braking x in some cells that are entered with y [1/s].

    Args:
        cells: Cells of the motion.
        cell: Indices of the cells, shape (m,).
        y: s'^2 at the beginning of each, in [0, 1], shape (m,).

    Returns:
        Shape (m,); NaN where no x is admissible.
    """
    width = cells.widths[cell]
    lower_bounds, upper_bounds = np.zeros((3, len(cell))), np.full((3, len(cell)), _MAX_BRAKING)
    for constraint in cells.all_constraints:
        limits = constraint.bounds[cell], constraint.path_acceleration_error[cell]
        for i, without_braking, by_braking in constraint.cell_conditions(cell, y, width):
            lower, upper = _braking_interval(without_braking, by_braking, *limits)
            lower_bounds[i] = np.maximum(lower_bounds[i], lower)
            upper_bounds[i] = np.minimum(upper_bounds[i], upper)
    can_rest = cells.can_rest[cell]
    braking_to_rest = upper_bounds[[0, 2]].min(axis=0)
    braking_to_rest = np.where(braking_to_rest >= lower_bounds[0], braking_to_rest, 0.0)
    braking_through = np.minimum(
        upper_bounds[:2].min(axis=0), np.where(can_rest, y, y / 2) / (2 * width)
    )
    # Where the motion cannot rest, it may only continue at s' = 1.
    fallback = np.where(can_rest | (y == 1), 0.0, np.nan)
    braking_through = np.where(
        braking_through >= lower_bounds[:2].max(axis=0), braking_through, fallback
    )
    braking_through[~can_rest & (y - 2 * width * braking_through < _REST_TOLERANCE)] = np.nan
    return np.where(can_rest & (2 * braking_to_rest * width >= y), braking_to_rest, braking_through)


def _braking_interval(
    without_braking: Array, by_braking: Array, bound: Array, error: Array
) -> tuple[Array, Array]:
    """Return the interval of x per cell for which |u - w x| <= bound - x error throughout.

    Args:
        without_braking: u, shape (m, k, blocks, size).
        by_braking: w, shape (m, k, blocks, size).
        bound: Bound on the norm, shape (m, blocks).
        error: Bound on the error of w, shape (m, blocks).
    """
    bound, error = bound[:, None], error[:, None]
    square = _dot(by_braking, by_braking) - error**2
    along = _dot(without_braking, by_braking) - bound * error
    size = _dot(without_braking, without_braking)
    discriminant = along**2 + square * (bound**2 - size)
    is_quadratic = square > _ZERO_SQUARED_SIZE
    root, divisor = np.sqrt(np.maximum(discriminant, 0.0)), np.where(is_quadratic, square, 1.0)
    lower = np.where(is_quadratic, (along - root) / divisor, -np.inf).max(axis=(1, 2))
    upper = np.where(is_quadratic, (along + root) / divisor, np.inf)
    is_empty = np.where(is_quadratic, discriminant < 0, size > bound**2) | (bound < 0)
    if error.any():
        # Where |w| <= error, |u| + 2 x error is a bound on the left side plus x error.
        limits = np.where(is_quadratic, bound, (bound - np.sqrt(size)) / 2) / np.where(
            error > 0, error, 1.0
        )
        upper = np.minimum(upper, np.where(error > 0, limits, np.inf))
    return lower, np.where(is_empty.any(axis=(1, 2)), -np.inf, upper.min(axis=(1, 2)))


def _dot(left: Array, right: Array) -> Array:
    return np.einsum("mkbs,mkbs->mkb", left, right)


def _can_stop(cells: MotionCells, starts: Indices, duration: float, deadline: Deadline) -> Any:
    """Return in which of some cells a smooth stop of a given duration can begin."""
    can_stop = np.ones(len(starts), dtype=bool)
    integral = _PROFILE_TABLE - _PROFILE_TABLE**3 + _PROFILE_TABLE**4 / 2
    pending, step = np.arange(len(starts)), 0
    while len(pending):
        deadline.check("certify")
        cell = starts[pending] + step
        entry = (cells.begins[cell] - cells.begins[starts[pending]]) / duration
        exit_ = entry + cells.widths[cell] / duration
        u0 = np.maximum(np.interp(entry, integral, _PROFILE_TABLE) - _TABLE_ERROR, 0.0)
        u1 = np.minimum(np.interp(exit_, integral, _PROFILE_TABLE) + _TABLE_ERROR, 1.0)
        is_satisfied = _is_satisfied(cells, cell, u0, u1, duration) & (
            cells.can_rest[cell] | (exit_ < 0.5)
        )
        can_stop[pending[~is_satisfied]] = False
        is_moving = is_satisfied & (exit_ < 0.5) & (cell + 1 < len(cells.begins))
        pending, step = pending[is_moving], step + 1
    return can_stop


def _is_satisfied(cells: MotionCells, cell: Indices, u0: Array, u1: Array, duration: float) -> Any:
    """Return in which cells the limits hold while u goes from u0 to u1."""
    path_velocity = np.stack([_smooth_profile(u1), _smooth_profile(u0)])
    steepest = np.where((u0 < 0.5) & (u1 > 0.5), 0.25, np.maximum(u0 * (1 - u0), u1 * (1 - u1)))
    flattest = np.minimum(u0 * (1 - u0), u1 * (1 - u1))
    path_acceleration = np.stack([-6 * steepest, -6 * flattest]) / duration
    path_jerk = np.stack([-6 + 12 * u0, -6 + 12 * u1]) / duration**2
    is_satisfied = np.ones(len(cell), dtype=bool)
    for constraint in cells.stop_constraints:
        is_satisfied &= constraint.is_satisfied(cell, path_velocity, path_acceleration)
    for rates in cells.rates:
        first, second, third = (form[:, cell] for form in rates.hulls)
        vdot = interval_product(second, _nonnegative_power(path_velocity, 2)) + interval_product(
            first, path_acceleration
        )
        vddot = interval_product(third, _nonnegative_power(path_velocity, 3)) + interval_product(
            first, path_jerk
        )
        vddot += 3 * interval_product(
            second,
            np.stack([
                path_acceleration[0] * path_velocity[1],
                path_acceleration[1] * path_velocity[0],
            ]),
        )
        vdot -= rates.acceleration_offsets[:, None] * MAX_UTILIZATION
        for bounded, limit in ((vdot, rates.limits[1]), (vddot, rates.limits[2])):
            sizes = np.linalg.norm(np.abs(bounded).max(axis=0), axis=2)
            is_satisfied &= (sizes <= limit * MAX_UTILIZATION).all(axis=1)
    return is_satisfied


def _smooth_profile(u: Array) -> Array:
    return 1 - 3 * u**2 + 2 * u**3


def _nonnegative_power(path_velocity: Array, power: int) -> Array:
    return np.maximum(path_velocity, 0.0) ** power
