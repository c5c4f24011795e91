"""What limits of velocity, acceleration and jerk allow: the least duration, and the peak rate."""

import numpy as np
import ruckig

from benchmarks.motion_bench_maker.referee import Polynomials

# Ruckig's cycle [s], which only its online mode uses.
_CYCLE_TIME = 0.01
# Of setpoints [s]: what roboplan delivers by default, and slow for a controller.
_PERIOD = 0.01


def peak_rate(motion: Polynomials, velocity: np.ndarray, acceleration: np.ndarray) -> float:
    """Return the largest rate of a motion over its limit, as setpoints 10 ms apart show it.

    That is velocities at the instants, and between two of them the mean acceleration, which the
    motion reaches somewhere: it asks for at least this much, however it goes between.

    Args:
        motion: In the order of the limits.
        velocity: Limits [rad/s], shape (n,).
        acceleration: Limits [rad/s^2], shape (n,).
    """
    first, last = motion.breaks[0], motion.breaks[-1]
    instants = np.append(np.arange(first, last - 0.1 * _PERIOD, _PERIOD), last)
    rates = motion.velocities(instants)
    means = np.diff(rates, axis=0) / np.diff(instants)[:, None]
    return float(max(np.abs(rates / velocity).max(), np.abs(means / acceleration).max()))


def least_duration(
    moved: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    jerk: np.ndarray | None = None,
) -> float:
    """Return the time of the slowest joint from rest to rest, each by itself.

    Args:
        moved: From start to goal [rad], shape (n,).
        velocity: Limits [rad/s], shape (n,).
        acceleration: Limits [rad/s^2], shape (n,).
        jerk: Limits [rad/s^3], shape (n,), or None for none.
    """
    distance = np.abs(moved)
    if jerk is not None:
        return _least_duration_with_jerk(distance, velocity, acceleration, jerk)
    ramps = 2 * np.sqrt(distance / acceleration)
    trapezoid = distance / velocity + velocity / acceleration
    return float(np.where(distance < velocity**2 / acceleration, ramps, trapezoid).max())


def _least_duration_with_jerk(
    distance: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, jerk: np.ndarray
) -> float:
    """Return the same by ruckig, which is time-optimal from rest to rest."""
    count = len(distance)
    wanted, found = ruckig.InputParameter(count), ruckig.Trajectory(count)
    wanted.synchronization = ruckig.Synchronization.No
    wanted.target_position = distance.tolist()
    wanted.max_velocity, wanted.max_acceleration = velocity.tolist(), acceleration.tolist()
    wanted.max_jerk = jerk.tolist()
    ruckig.Ruckig(count, _CYCLE_TIME).calculate(wanted, found)
    return float(max(found.independent_min_durations))
