"""A motion of two joints, and a driver that follows its setpoints with an optional offset."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.geometry.touching_pair import TouchingPair
from planning.domain.robot.joints import Joint, JointLimits, JointType
from planning.execute.driver import DriverTraits, Measurement, Setpoint
from planning.execute.execution import Execution

JOINTS = (Joint("arm::a", JointType.REVOLUTE), Joint("arm::b", JointType.PRISMATIC))
ACCELERATION = 3.0
EFFORT = 40.0


def quintic(duration: float = 2.0) -> TimedTrajectory:
    """Return a motion from rest to rest: 10 x^3 - 15 x^4 + 6 x^5."""
    delta = np.array([1.0, -0.5])
    coefficients = np.zeros((1, 6, 2))
    for power, factor in ((3, 10.0), (4, -15.0), (5, 6.0)):
        coefficients[0, power] = factor * delta / duration**power
    return TimedTrajectory(JOINTS, np.array([0.0, duration]), np.zeros((1, 2)), coefficients)


def limits() -> JointLimits:
    return JointLimits(
        lower=np.array([-9.0, -9.0]),
        upper=np.array([9.0, 9.0]),
        velocity=np.array([5.0, 5.0]),
        acceleration=np.array([ACCELERATION, ACCELERATION]),
        jerk=np.array([100.0, 100.0]),
        effort=np.array([np.inf, EFFORT]),
        blocks=((0,), (1,)),
    )


@dataclass
class EchoDriver:
    """Follows its setpoints, plus `offset`, and is in contact from the time `touches_at` on."""

    offset: float = 0.0
    touches_at: float = np.inf
    torques: np.ndarray | None = None
    max_realtime_factor: float = 100.0
    sent: list[Setpoint] = field(default_factory=list)
    is_stopped: bool = False

    @property
    def traits(self) -> DriverTraits:
        return DriverTraits("echo", 0.004, self.max_realtime_factor, rests_when_lost=True)

    def start(self) -> Measurement:
        return self.read(0.0)

    def stop(self) -> None:
        self.is_stopped = True

    def send(self, setpoint: Setpoint) -> None:
        self.sent.append(setpoint)

    def read(self, time: float) -> Measurement:
        touching = TouchingPair(("arm::link", "wall"), -0.002, np.zeros((2, 3)), 12.5)
        contacts = (touching,) if time >= self.touches_at else ()
        if not self.sent:
            return Measurement(time, np.zeros(2), np.zeros(2), contacts, self.torques)
        last = self.sent[-1]
        dt = time - last.time
        q = last.q + last.v * dt + 0.5 * last.vdot * dt**2 + self.offset
        return Measurement(time, q, last.v + last.vdot * dt, contacts, self.torques)


@pytest.fixture(scope="session")
def execution() -> Execution:
    return Execution(quintic(), limits())


@pytest.fixture(scope="session")
def new_driver() -> Callable[..., EchoDriver]:
    return EchoDriver
