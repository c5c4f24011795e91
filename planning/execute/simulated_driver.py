"""SimulatedDriver: driver of a simulation of the robot's dynamics."""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from planning.domain.arrays import Array
from planning.domain.geometry.touching_pair import TouchingPair
from planning.domain.scene.held_pose import HeldPose
from planning.execute.abort_reasons import driver_lost
from planning.execute.driver import DriverTraits, Measurement, Setpoint

_TRAITS = DriverTraits(
    name="simulated", period=0.004, max_realtime_factor=100.0, rests_when_lost=True
)


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

    @property
    def torques(self) -> Array:
        """Torques or forces of the group's motors now, shape (nv,)."""
        ...

    @property
    def held(self) -> tuple[HeldPose, ...]:
        """Where the objects are that are held by contact."""
        ...

    def command(self, q: Array, v: Array, vdot: Array) -> None:
        """Follow q, v, vdot from now on."""
        ...

    def advance_to(self, time: float) -> Sequence[TouchingPair]:
        """Simulate until `time` [s] and return the body pairs in contact on the way."""
        ...


class SimulatedDriver:
    """Driver of a simulated robot; its clock advances only in `read`."""

    def __init__(self, simulation: SimulatedGroup) -> None:
        """Drive a simulated joint group, which is at time 0."""
        self._simulation = simulation
        self._is_stopped = False

    @property
    def traits(self) -> DriverTraits:
        """Properties of every simulation."""
        return _TRAITS

    def start(self) -> Measurement:
        """Return the measurement at time 0."""
        return self.read(0.0)

    def send(self, setpoint: Setpoint) -> None:
        """Follow `setpoint` from the present time of the simulation on."""
        self._require_running()
        self._simulation.command(setpoint.q, setpoint.v, setpoint.vdot)

    def read(self, time: float) -> Measurement:
        """Simulate until `time` [s] and return the measurement then."""
        self._require_running()
        simulation = self._simulation
        contacts = tuple(simulation.advance_to(time))
        torques, held = simulation.torques, simulation.held
        return Measurement(time, simulation.q, simulation.v, contacts, torques, held)

    def stop(self) -> None:
        """End: the simulation stands still where it is."""
        self._is_stopped = True

    def _require_running(self) -> None:
        if self._is_stopped:
            raise driver_lost(_TRAITS.name, "it was stopped", rests=True)
