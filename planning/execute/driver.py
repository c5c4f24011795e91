"""Driver: interface that sends setpoints to a robot and reads measurements.

A driver for another robot is written against `tests/contracts/test_driver.py`.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.touching_pair import TouchingPair
from planning.domain.scene.held_pose import HeldPose
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Setpoint(Value):
    """Setpoint of a joint group: desired motion from `time` on, vdot constant until the next one.

    Attributes:
        time: On the driver's clock [s].
        q: Positions [rad or m], shape (nq,).
        v: Drake's generalized velocities, shape (nv,).
        vdot: Their derivative, shape (nv,).
    """

    time: float
    q: Float64[np.ndarray, " nq"]
    v: Float64[np.ndarray, " nv"]
    vdot: Float64[np.ndarray, " nv"]


@dataclass(frozen=True, eq=False)
class Measurement(Value):
    """Measured motion of a joint group.

    Attributes:
        time: On the driver's clock [s].
        q: Positions [rad or m], shape (nq,).
        v: Drake's generalized velocities, shape (nv,).
        contacts: Body pairs in contact since the previous measurement, deepest first.
        torques: Torques or forces of the joints' motors [N m or N], shape (nv,); None where they
            are not known.
        held: Where the objects are that are held by contact, where that is measured.
    """

    time: float
    q: Float64[np.ndarray, " nq"]
    v: Float64[np.ndarray, " nv"]
    contacts: tuple[TouchingPair, ...] = ()
    torques: Float64[np.ndarray, " nv"] | None = None
    held: tuple[HeldPose, ...] = ()


@dataclass(frozen=True)
class DriverTraits:
    """Properties of a driver that do not change.

    Attributes:
        name: For people and messages.
        period: Time between setpoints, on the driver's clock [s].
        max_realtime_factor: Largest ratio of the driver's clock to the caller's. A clock that only
            advances in `read` may be any number of times as fast; that of a robot is real time, 1.
        rests_when_lost: Whether the robot is known to be at rest, where it was last measured, once
            its driver is gone: a simulation is, a robot of metal goes on by itself.
    """

    name: str
    period: float
    max_realtime_factor: float
    rests_when_lost: bool


@runtime_checkable
class Driver(Protocol):
    """Interface to a robot's controller, with a clock of its own [s].

    Life cycle: `start` once, then `send` and `read` in turns, then `stop`.
    """

    @property
    def traits(self) -> DriverTraits:
        """Properties of the driver; known before `start`."""
        ...

    def start(self) -> Measurement:
        """Take the robot over where it is, set the clock to 0 and return the first measurement.

        Raises:
            DriverLost: The robot does not answer, or moves.
        """
        ...

    def send(self, setpoint: Setpoint) -> None:
        """Send a setpoint, which the robot follows from its time on until the next one.

        Raises:
            DriverLost: The robot does not answer, or is not controlled by this driver any more.
        """
        ...

    def read(self, time: float) -> Measurement:
        """Return the measurement at `time` [s], or the first one later; waits for it.

        Times of successive calls increase, and so do those of measurements.

        Raises:
            DriverLost: No measurement came in time.
            ExecutionFailure: The motion cannot be measured any more, as a simulation diverged.
        """
        ...

    def stop(self) -> None:
        """Let go of the robot, which comes to rest if it moves; never raises, and may be repeated.

        Nothing can be sent or read afterwards: both raise DriverLost.
        """
        ...
