"""Driver: what moves a robot and reads it back; and the one over our simulation."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.body_pair import BodyPair
from planning.domain.value import Value

type Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True, eq=False)
class Setpoint(Value):
    """What a group should do from `time` on: vdot stays as it is until the next setpoint.

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
    """What a group does.

    Attributes:
        time: On the driver's clock [s].
        q: Positions [rad or m], shape (nq,).
        v: Drake's generalized velocities, shape (nv,).
        contacts: Bodies that have touched since the reading before, deepest first; `distance` is
            negative.
    """

    time: float
    q: Float64[np.ndarray, " nq"]
    v: Float64[np.ndarray, " nv"]
    contacts: tuple[BodyPair, ...] = ()


@runtime_checkable
class Driver(Protocol):
    """What moves a robot. It has a clock of its own, in seconds from when it began."""

    def send(self, setpoint: Setpoint) -> None:
        """Follow `setpoint` from its time on, until the next one."""
        ...

    def read(self, time: float) -> Measurement:
        """Return what the robot does at `time`; times never decrease."""
        ...


@runtime_checkable
class SimulatedGroup(Protocol):
    """What `SimulatedDriver` needs of `planning.world.mechanics.simulation.Simulation`."""

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
        """Simulate until `time` [s] and return what touched on the way."""
        ...


@dataclass(frozen=True, eq=False)
class SimulatedDriver:
    """Moves a simulated robot; its clock stands still but for `read`.

    Attributes:
        simulation: Where the robot is.
    """

    simulation: SimulatedGroup

    def send(self, setpoint: Setpoint) -> None:
        """Follow `setpoint` from the simulation's present on."""
        self.simulation.command(setpoint.q, setpoint.v, setpoint.vdot)

    def read(self, time: float) -> Measurement:
        """Simulate until `time` and return what the robot does then."""
        contacts = tuple(self.simulation.advance_to(time))
        return Measurement(time, self.simulation.q, self.simulation.v, contacts)
