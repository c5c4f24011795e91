"""KinematicDriver: driver of a robot that follows its setpoints exactly, without dynamics."""

import numpy as np

from planning.domain.arrays import Array
from planning.domain.robot.manifold import Manifold
from planning.execute.abort_reasons import driver_lost
from planning.execute.driver import DriverTraits, Measurement, Setpoint

_TRAITS = DriverTraits(
    name="kinematic", period=0.004, max_realtime_factor=100.0, rests_when_lost=True
)


class KinematicDriver:
    """Driver of a robot without mass: it is where the last setpoint leads.

    Its clock advances only in `read`. Not measured: contacts and torques, as nothing has forces.
    """

    def __init__(self, manifold: Manifold, start: Array) -> None:
        """Place the group at rest.

        Args:
            manifold: Configuration manifold of the group.
            start: Where it is, shape (nq,).
        """
        self._manifold = manifold
        still = np.zeros(manifold.num_velocities)
        self._setpoint = Setpoint(0.0, start, still, still)
        self._is_stopped = False

    @property
    def traits(self) -> DriverTraits:
        """Properties of every such robot."""
        return _TRAITS

    def start(self) -> Measurement:
        """Return the measurement at time 0."""
        return self.read(0.0)

    def send(self, setpoint: Setpoint) -> None:
        """Be at `setpoint` at its time, and go on from there with constant vdot."""
        self._require_running()
        self._setpoint = setpoint

    def read(self, time: float) -> Measurement:
        """Return where the last setpoint leads until `time` [s]."""
        self._require_running()
        last = self._setpoint
        elapsed = max(0.0, time - last.time)
        displacement = elapsed * last.v + 0.5 * elapsed**2 * last.vdot
        tangent = self._manifold.tangent_velocity(last.q, displacement)
        q = self._manifold.plus(last.q, tangent)
        return Measurement(time, q, last.v + elapsed * last.vdot)

    def stop(self) -> None:
        """End: the robot stands still where it is."""
        self._is_stopped = True

    def _require_running(self) -> None:
        if self._is_stopped:
            raise driver_lost(_TRAITS.name, "it was stopped", rests=True)
