"""Profiles under velocity, acceleration and jerk limits, by ruckig on the path parameter.

Berscheid and Kroeger, "Jerk-limited real-time trajectory generation with arbitrary target states",
RSS 2021. The path is one degree of freedom, from rest to rest, state to state: ruckig's waypoint
mode would call a service in the network and is never used. With constants M_n >= |r^(n)| on the
stretch, bounds V, A, J on sdot, sddot and sdddot keep every limit if

    M_1 V <= v,   M_1 A + M_2 V^2 <= a,   M_1 J + 3 M_2 V A + M_3 V^3 <= j.

On a straight line that is exact and time-optimal.
"""

from typing import Any

import numpy as np
import ruckig

from planning.domain.curve import JointSpline
from planning.domain.joints import JointLimits
from planning.errors import RetimingFailed
from planning.retime.bounds import block_peaks
from planning.retime.profile import SpeedProfile

type Array = np.ndarray[Any, np.dtype[np.float64]]

_SPEEDS = np.geomspace(1.0, 0.02, 24)
_ACCELERATIONS = np.geomspace(1.0, 0.05, 8)
# A cycle time is asked for by ruckig's constructor and used only in its online mode [s].
_CYCLE = 0.01


def ruckig_profile(stretch: JointSpline, limits: JointLimits) -> SpeedProfile:
    """Return the quickest rest-to-rest profile along a stretch that such bounds allow.

    Raises:
        RetimingFailed: ruckig finds none.
    """
    peaks = [block_peaks(stretch, limits, order).max(axis=0) for order in (1, 2, 3)]
    length = float(stretch.breaks[-1] - stretch.breaks[0])
    best: Any = None
    for bounds in _choices(peaks, limits):
        trajectory = _rest_to_rest(length, bounds)
        if best is None or trajectory.duration < best.duration:
            best = trajectory
    if best is None:
        message = "no speed along the path keeps the jerk limits"
        raise RetimingFailed(message, {"method": "ruckig"})
    return _as_profile(best, stretch)


def _choices(peaks: list[Array], limits: JointLimits) -> list[tuple[float, float, float]]:
    """Return some bounds (V, A, J) on the edge of what the limits allow."""
    m1, m2, m3 = peaks
    moving = m1 > 0
    m1, m2, m3 = m1[moving], m2[moving], m3[moving]
    top = float((limits.velocity[moving] / m1).min())
    is_straight = not m2.any() and not m3.any()
    chosen: list[tuple[float, float, float]] = []
    for speed in top * (_SPEEDS[:1] if is_straight else _SPEEDS):
        most = float(((limits.acceleration[moving] - m2 * speed**2) / m1).min())
        for share in _ACCELERATIONS[:1] if is_straight else _ACCELERATIONS:
            acceleration = most * share
            spent = 3 * m2 * speed * acceleration + m3 * speed**3
            jerk = float(((limits.jerk[moving] - spent) / m1).min())
            if acceleration > 0 and jerk > 0:
                chosen.append((float(speed), acceleration, jerk))
    return chosen


def _rest_to_rest(length: float, bounds: tuple[float, float, float]) -> Any:
    generator = ruckig.Ruckig(1, _CYCLE)
    wanted = ruckig.InputParameter(1)
    wanted.current_position, wanted.target_position = [0.0], [length]
    wanted.max_velocity, wanted.max_acceleration, wanted.max_jerk = ([bound] for bound in bounds)
    trajectory = ruckig.Trajectory(1)
    result = generator.calculate(wanted, trajectory)
    if result not in (ruckig.Result.Working, ruckig.Result.Finished):
        message = f"ruckig answers {result}"
        raise RetimingFailed(message, {"method": "ruckig", "result": str(result)})
    return trajectory


def _as_profile(trajectory: Any, stretch: JointSpline) -> SpeedProfile:
    """Return ruckig's phases, joined exactly: each starts where the one before it ends."""
    profile = trajectory.profiles[0][0]
    begin, end = float(stretch.breaks[0]), float(stretch.breaks[-1])
    s, v, a = 0.0, 0.0, 0.0
    rows: list[tuple[float, float, float, float, float]] = []
    for h, j in zip(profile.t, profile.j, strict=True):
        if h <= 1e-12:
            continue
        rows.append((s, v, a, j, h))
        s += h * (v + h * (a / 2 + h * j / 6))
        v += h * (a + h * j / 2)
        a += h * j
    columns = np.array(rows).T
    # The phases add up to the length but for rounding; the parameter is scaled to end exactly.
    scale = (end - begin) / s
    places = np.append(begin + columns[0] * scale, end)
    v0, a0, j0 = columns[1:4] * scale
    return SpeedProfile(places, v0, a0, j0, columns[4])
