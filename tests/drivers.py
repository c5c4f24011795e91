"""An independent look at how a base moves, from samples: nothing of what made the motion."""

import numpy as np

from planning.domain.curves.curve import TimedTrajectory


def body_velocities(
    trajectory: TimedTrajectory, at: tuple[int, int] = (0, 0), count: int = 4001
) -> np.ndarray:
    """Return v_x, v_y and yaw rate of a planar joint in its own frame, shape (count, 3).

    Args:
        trajectory: The motion.
        at: Where the joint's coordinates begin in q and in v.
        count: Of samples, evenly spread.
    """
    times = np.linspace(0.0, trajectory.duration, count)
    yaw = trajectory.positions(times)[:, at[0] + 2]
    x, y, turn = trajectory.velocities(times)[:, at[1] : at[1] + 3].T
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack([c * x + s * y, c * y - s * x, turn], axis=1)


def assert_driven(
    trajectory: TimedTrajectory, radius: float, *, reverse: bool, at: tuple[int, int] = (0, 0)
) -> None:
    """Assert that the base neither slips nor turns too tightly, nor backs up where it may not."""
    ahead, aside, turn = body_velocities(trajectory, at).T
    moves = np.hypot(ahead, aside) > 1e-6
    assert moves.any()
    assert np.abs(aside[moves] / ahead[moves]).max() < 1e-5
    assert np.abs(turn[moves] / ahead[moves]).max() * radius < 1 + 1e-4
    assert np.abs(turn[~moves]).max(initial=0.0) * radius < 2e-6
    if not reverse:
        assert ahead.min() > -1e-9
