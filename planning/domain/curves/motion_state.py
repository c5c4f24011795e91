"""MotionState: position, velocity and acceleration of a group at one instant."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class MotionState(Value):
    """Kinematic state of a group.

    Attributes:
        q: Positions [rad or m], shape (nq,).
        v: Velocities [rad/s or m/s], shape (nv,).
        vdot: Accelerations [rad/s^2 or m/s^2], shape (nv,).
    """

    q: Float64[np.ndarray, " nq"]
    v: Float64[np.ndarray, " nv"]
    vdot: Float64[np.ndarray, " nv"]

    @classmethod
    def of(cls, trajectory: TimedTrajectory, time: float) -> "MotionState":
        """Evaluate a trajectory at an instant [s]."""
        at = np.array([time])
        rates = (trajectory.velocities(at)[0], trajectory.accelerations(at)[0])
        return cls(trajectory.positions(at)[0], *rates)
