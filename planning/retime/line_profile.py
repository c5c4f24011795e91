"""Line profile: the fastest profile through cells of a path with given speeds at their edges.

On a line it is full acceleration, full speed, full braking (trapezoidal profile: Lynch and Park,
"Modern Robotics", 2017, section 9.2.2.2); a curved cell is passed with constant acceleration.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.kernel.native import native
from planning.retime.profile import SpeedProfile

# Shortest phase relative to the whole duration; shorter ones are left out.
_MIN_PHASE_SHARE = 1e-12


@dataclass(frozen=True)
class LineLimits:
    """Limits on each of n cells that are lines.

    Attributes:
        is_line: Whether the cell is a line, boolean, shape (n,).
        speed: Largest ds/dt on it [1/s], shape (n,).
        acceleration: Largest d2s/dt2 on it [1/s^2], shape (n,).
        braking: Largest -d2s/dt2 on it [1/s^2], shape (n,).
    """

    is_line: Any
    speed: Array
    acceleration: Array
    braking: Array


def line_profile(s0: float, s1: float, speed: float, acceleration: float) -> SpeedProfile:
    """Return the time-optimal rest-to-rest profile along a line.

    Args:
        s0: Path parameter at the beginning.
        s1: Path parameter at the end, s1 > s0.
        speed: Largest ds/dt [1/s].
        acceleration: Largest d2s/dt2 [1/s^2].
    """
    accelerations = np.array([acceleration])
    lines = LineLimits(np.array([True]), np.array([speed]), accelerations, accelerations)
    return profile_between(np.array([s0, s1]), np.zeros(2), lines)


def profile_between(edges: Array, x: Array, lines: LineLimits) -> SpeedProfile:
    """Return the profile with given squared speeds at the edges of cells.

    Where a line's acceleration does not connect the speeds at its ends, more of it is used.

    Args:
        edges: Path parameter, increasing, shape (n + 1,).
        x: (ds/dt)^2 at the edges [1/s^2], shape (n + 1,). On curved cells not zero at both ends.
        lines: Limits on cells that are lines.
    """
    module = native()
    if module is None:
        return profile_between_in_numpy(edges, x, lines)
    arrays = module.profile_between(
        edges, x, lines.is_line, lines.speed, lines.acceleration, lines.braking
    )
    return SpeedProfile(*arrays)


def profile_between_in_numpy(edges: Array, x: Array, lines: LineLimits) -> SpeedProfile:
    """Return the same without the kernel, which has the same sums."""
    v, widths = np.sqrt(x), np.diff(edges)
    before, after = v[:-1], v[1:]
    needed = (x[1:] - x[:-1]) / (2 * widths)
    a, b = _connecting_accelerations(lines, needed)
    # Squared speed at which full acceleration meets full braking; for equal ones the shares are
    # 1/2.
    braking_share = b / (a + b)
    meeting_speed_squared = (
        braking_share * x[:-1] + (1 - braking_share) * x[1:] + 2 * braking_share * a * widths
    )
    top_speeds = np.minimum(lines.speed, np.sqrt(meeting_speed_squared))
    top_speeds = np.maximum(top_speeds, np.maximum(before, after))
    times = np.stack([(top_speeds - before) / a, np.zeros_like(a), (top_speeds - after) / b])
    acceleration_lengths = times[0] * (top_speeds + before) / 2
    braking_lengths = times[2] * (top_speeds + after) / 2
    times[1] = np.maximum(widths - acceleration_lengths - braking_lengths, 0.0) / top_speeds
    curved = np.flatnonzero(~lines.is_line)
    times[0, curved] = 2 * widths[curved] / (before[curved] + after[curved])
    times[1:, curved] = 0.0
    keep = times > _MIN_PHASE_SHARE * times.sum()
    # The distance of an omitted phase is added to the next, so that every edge begins a phase.
    parameters = np.stack([
        edges[:-1],
        np.where(keep[0], edges[:-1] + acceleration_lengths, edges[:-1]),
        np.where(keep[0] | keep[1], edges[1:] - braking_lengths, edges[:-1]),
    ])
    speeds = np.stack([before, top_speeds, top_speeds])
    accelerations = np.stack([np.where(lines.is_line, a, needed), np.zeros_like(a), -b])
    kept = keep.T
    return SpeedProfile(
        np.append(parameters.T[kept], edges[-1]),
        speeds.T[kept],
        accelerations.T[kept],
        np.zeros(int(kept.sum())),
        times.T[kept],
    )


def _connecting_accelerations(lines: LineLimits, needed: Array) -> tuple[Array, Array]:
    """Return acceleration and braking, at least the values that connect the speeds."""
    is_symmetric = lines.acceleration == lines.braking
    both = np.maximum(lines.acceleration, np.abs(needed))
    a = np.where(is_symmetric, both, np.maximum(lines.acceleration, needed))
    return a, np.where(is_symmetric, both, np.maximum(lines.braking, -needed))
