r"""Stops along the path of a trajectory: from every instant, within limits, as short as possible.

A trajectory q(t) followed at t = s(clock) from rate s' = 1 to s' = 0 stays on its path, so it is as
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
does not depend on the rate: where the static load exceeds a joint's limit no stop may end, and
there may be no admissible x. Stops that meet such a place must begin later.

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
from planning.certify.joints.limit_checks import MAX_UTILISATION
from planning.certify.stopping.stop_constraint import spread
from planning.domain.arrays import Array, Indices
from planning.domain.request.deadline import UNHURRIED, Deadline

_STANDS = 1e-12
# Squared rate that counts as zero: it moves nothing even with the largest ramp.
_STILL = 1e-200
# Range of ramps: any that ends within a cell is above the first, any meaningful one below the
# second [1/s].
_LEAST_RAMP, _MOST_RAMP = 1e-12, 1e9
# Durations of stops under jerk limits: shortest [s], and ratio of consecutive ones.
_SHORTEST, _STEP = 0.01, 1.15
# Table of the profile's integral, and the error of a lookup.
_TABLE = np.linspace(0.0, 1.0, 4097)
_OFF = 1e-3


@dataclass(frozen=True)
class Stops:
    """Stops from the beginning of each cell, and from the end.

    Attributes:
        times: Time until rest [s], shape (n + 1,).
        ends: Index of the first cell not entered, shape (n + 1,).
    """

    times: Float64[np.ndarray, " n_plus_1"]
    ends: Int[np.ndarray, " n_plus_1"]


def hardest_stops(cells: MotionCells, deadline: Deadline = UNHURRIED) -> Stops:
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
        at, before = ends[moving], y[moving]
        width = cells.widths[at]
        ramp = ramps(cells, at, before)
        after = before - 2 * width * ramp
        after[after < _STANDS] = 0.0
        # Coming to rest within the cell takes s' / x.
        passed = np.where(after > 0, width, before / (2 * np.maximum(ramp, _LEAST_RAMP)))
        times[moving] += 2 * passed / (np.sqrt(before) + np.sqrt(after))
        y[moving] = after
        ends[moving] += 1
        moving = moving[(after > 0) & (ends[moving] < count)]
    return _or_finished(cells, *_waited(cells, times, ends))


def _waited(cells: MotionCells, times: Array, ends: Indices) -> tuple[Array, Indices]:
    """Return stops with those that do not exist replaced by the next one, after a delay."""
    for i in range(len(cells.begins) - 1, -1, -1):
        if np.isnan(times[i]):
            times[i], ends[i] = cells.widths[i] + times[i + 1], ends[i + 1]
    return times, ends


def smooth_stops(cells: MotionCells, deadline: Deadline = UNHURRIED) -> Stops:
    """Return stops under acceleration and jerk limits, by one profile, with the best delay.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    count, best = len(cells.begins), smooth_durations(cells, deadline)
    over = np.append(cells.begins + best, cells.end)
    # Of all stops that begin here or later, the one that ends first.
    soonest = np.arange(count + 1)
    for i in range(count - 1, -1, -1):
        soonest[i] = i if over[i] < over[soonest[i + 1]] else soonest[i + 1]
    edges = np.append(cells.begins, cells.end)
    # The profile's integral is T / 2.
    stands = edges[soonest] + np.append(best, 0.0)[soonest] / 2
    ends = np.searchsorted(edges, np.minimum(stands, cells.end) - 1e-12)
    return _or_finished(cells, over[soonest] - edges, np.maximum(ends, np.arange(count + 1)))


def smooth_durations(
    cells: MotionCells, deadline: Deadline = UNHURRIED
) -> Float64[np.ndarray, " n"]:
    """Return durations of smooth stops that begin with each cell [s], infinite if none passes."""
    best = np.full(len(cells.begins), np.inf)
    lasting = _SHORTEST
    while lasting < 2 * cells.end:
        open_ = np.flatnonzero(np.isinf(best))
        best[open_[_passes(cells, open_, lasting, deadline)]] = lasting
        lasting *= _STEP
    return best


def _or_finished(cells: MotionCells, times: Array, ends: Indices) -> Stops:
    """Return the stops, replaced by the end of the motion where that is sooner."""
    left = cells.end - np.append(cells.begins, cells.end)
    is_sooner = left < times
    return Stops(np.where(is_sooner, left, times), np.where(is_sooner, len(cells.begins), ends))


def ramps(cells: MotionCells, at: Indices, y: Array) -> Array:
    """Return the hardest braking x in some cells that are entered with y [1/s].

    Args:
        cells: Cells of the motion.
        at: Indices of the cells, shape (m,).
        y: s'^2 at the beginning of each, in [0, 1], shape (m,).

    Returns:
        Shape (m,); NaN where no x is admissible.
    """
    width = cells.widths[at]
    lows, highs = np.zeros((3, len(at))), np.full((3, len(at)), _MOST_RAMP)
    for load in cells.all_loads:
        limits = load.bounds[at], load.off_slope[at]
        for i, begun, part in load.sides(at, y, width):
            least, most = _between(begun, part, *limits)
            lows[i], highs[i] = np.maximum(lows[i], least), np.minimum(highs[i], most)
    holds = cells.holds[at]
    stands = np.where(highs[[0, 2]].min(axis=0) >= lows[0], highs[[0, 2]].min(axis=0), 0.0)
    goes_on = np.minimum(highs[:2].min(axis=0), np.where(holds, y, y / 2) / (2 * width))
    # Where the motion cannot rest, it may only continue at full rate.
    otherwise = np.where(holds | (y == 1), 0.0, np.nan)
    goes_on = np.where(goes_on >= lows[:2].max(axis=0), goes_on, otherwise)
    goes_on[~holds & (y - 2 * width * goes_on < _STANDS)] = np.nan
    return np.where(holds & (2 * stands * width >= y), stands, goes_on)


def _between(begun: Array, part: Array, bound: Array, off: Array) -> tuple[Array, Array]:
    """Return the interval of x per cell for which |begun - x part| <= bound - x off throughout.

    Args:
        begun: Shape (m, k, blocks, size).
        part: The same.
        bound: Shape (m, blocks).
        off: Bound on the error of part, shape (m, blocks).
    """
    bound, off = bound[:, None], off[:, None]
    square, along = _dot(part, part) - off**2, _dot(begun, part) - bound * off
    size = _dot(begun, begun)
    inner = along**2 + square * (bound**2 - size)
    counts = square > _STILL
    root, divisor = np.sqrt(np.maximum(inner, 0.0)), np.where(counts, square, 1.0)
    least = np.where(counts, (along - root) / divisor, -np.inf).max(axis=(1, 2))
    most = np.where(counts, (along + root) / divisor, np.inf)
    is_empty = np.where(counts, inner < 0, size > bound**2) | (bound < 0)
    if off.any():
        # Where |part| <= off, |begun| + 2 x off is a bound.
        ends = np.where(counts, bound, (bound - np.sqrt(size)) / 2) / np.where(off > 0, off, 1.0)
        most = np.minimum(most, np.where(off > 0, ends, np.inf))
    return least, np.where(is_empty.any(axis=(1, 2)), -np.inf, most.min(axis=(1, 2)))


def _dot(left: Array, right: Array) -> Array:
    return np.einsum("mkbs,mkbs->mkb", left, right)


def _passes(cells: MotionCells, starts: Indices, lasting: float, deadline: Deadline) -> Any:
    """Return in which of some cells a smooth stop of a given duration can begin."""
    passes = np.ones(len(starts), dtype=bool)
    integral = _TABLE - _TABLE**3 + _TABLE**4 / 2
    live, step = np.arange(len(starts)), 0
    while len(live):
        deadline.check("certify")
        at = starts[live] + step
        begun = (cells.begins[at] - cells.begins[starts[live]]) / lasting
        over = begun + cells.widths[at] / lasting
        u0 = np.maximum(np.interp(begun, integral, _TABLE) - _OFF, 0.0)
        u1 = np.minimum(np.interp(over, integral, _TABLE) + _OFF, 1.0)
        kept = _is_kept(cells, at, u0, u1, lasting) & (cells.holds[at] | (over < 0.5))
        passes[live[~kept]] = False
        goes_on = kept & (over < 0.5) & (at + 1 < len(cells.begins))
        live, step = live[goes_on], step + 1
    return passes


def _is_kept(cells: MotionCells, at: Indices, u0: Array, u1: Array, lasting: float) -> Any:
    """Return in which cells the limits hold while u goes from u0 to u1."""
    rate = np.stack([_smooth(u1), _smooth(u0)])
    steepest = np.where((u0 < 0.5) & (u1 > 0.5), 0.25, np.maximum(u0 * (1 - u0), u1 * (1 - u1)))
    flattest = np.minimum(u0 * (1 - u0), u1 * (1 - u1))
    ramp = np.stack([-6 * steepest, -6 * flattest]) / lasting
    twist = np.stack([-6 + 12 * u0, -6 + 12 * u1]) / lasting**2
    kept = np.ones(len(at), dtype=bool)
    for load in cells.loads:
        kept &= load.used(at, rate, ramp)
    for rates in cells.rates:
        first, second, third = (form[:, at] for form in rates.hulls)
        vdot = spread(second, _cubed(rate, 2)) + spread(first, ramp)
        vddot = spread(third, _cubed(rate, 3)) + spread(first, twist)
        vddot += 3 * spread(second, np.stack([ramp[0] * rate[1], ramp[1] * rate[0]]))
        vdot -= rates.middles[:, None] * MAX_UTILISATION
        for bounded, limit in ((vdot, rates.limits[1]), (vddot, rates.limits[2])):
            sizes = np.linalg.norm(np.abs(bounded).max(axis=0), axis=2)
            kept &= (sizes <= limit * MAX_UTILISATION).all(axis=1)
    return kept


def _smooth(u: Array) -> Array:
    return 1 - 3 * u**2 + 2 * u**3


def _cubed(rate: Array, power: int) -> Array:
    return np.maximum(rate, 0.0) ** power
