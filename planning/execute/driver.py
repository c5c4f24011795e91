"""Driver: interface that sends setpoints to a robot and reads measurements; one for simulation."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.geometry.body_pair import BodyPair
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
        contacts: Body pairs in contact since the previous measurement, deepest first; `distance`
            is negative.
    """

    time: float
    q: Float64[np.ndarray, " nq"]
    v: Float64[np.ndarray, " nv"]
    contacts: tuple[BodyPair, ...] = ()


@runtime_checkable
class Driver(Protocol):
    """Interface to a robot's controller, with a clock of its own [s] that starts at 0."""

    def send(self, setpoint: Setpoint) -> None:
        """Send a setpoint, which the robot follows from its time on until the next one."""
        ...

    def read(self, time: float) -> Measurement:
        """Return the measurement at `time` [s]; times of successive calls never decrease."""
        ...


@runtime_checkable
class SimulatedGroup(Protocol):
    """Interface of `planning.world.mechanics.simulation.Simulation` that `SimulatedDriver` uses."""

    @property
    def q(self) -> Array:
        """Positions of the group now, shape (nq,)."""
        ...

    @property
    def v(self) -> Array:
        """Velocities of the group now, shape (nv,)."""
        ...

    def command(self, q: Array, v: Array, vdot: Array) -> None:
        """Follow q, v, vdot from now on."""
        ...

    def advance_to(self, time: float) -> Sequence[BodyPair]:
        """Simulate until `time` [s] and return the body pairs in contact on the way."""
        ...


@dataclass(frozen=True, eq=False)
class SimulatedDriver:
    """Driver of a simulated robot; its clock advances only in `read`.

    Attributes:
        simulation: Simulated joint group.
    """

    simulation: SimulatedGroup

    def send(self, setpoint: Setpoint) -> None:
        """Follow `setpoint` from the present time of the simulation on."""
        self.simulation.command(setpoint.q, setpoint.v, setpoint.vdot)

    def read(self, time: float) -> Measurement:
        """Simulate until `time` [s] and return the measurement then."""
        contacts = tuple(self.simulation.advance_to(time))
        return Measurement(time, self.simulation.q, self.simulation.v, contacts)
