"""UrDriver: driver of an arm of Universal Robots, by RTDE and a program on its controller."""

import socket
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from planning.domain.arrays import Array
from planning.errors import DriverLost
from planning.execute.abort_reasons import driver_lost
from planning.execute.driver import DriverTraits, Measurement, Setpoint
from planning.execute.ur.rtde_connection import RtdeConnection
from planning.execute.ur.rtde_package import FieldValue
from planning.execute.ur.servo_program import (
    COMMAND,
    IDLE,
    RUNNING,
    SERVO,
    TARGETS,
    ServoOptions,
    servo_program,
)

NAME = "ur_rtde"
_OUTPUTS = ("timestamp", "actual_q", "actual_qd", "safety_mode", "runtime_state", RUNNING)
_INPUTS = (COMMAND, *TARGETS)
# Values of `safety_mode` in which the robot obeys: normal, and reduced speed.
_SAFE = {1: "normal", 2: "reduced"}
# The program has ended, or is about to.
_STOPPED = {1, 5}
# Largest speed of a robot at rest [rad/s].
_REST = 0.01


@dataclass(frozen=True)
class UrAddress:
    """Where a controller is.

    Attributes:
        host: Name or address.
        rtde_port: Of the data exchange.
        script_port: Where it takes programs (secondary interface).
        timeout: Longest silence before the robot counts as lost [s].
    """

    host: str
    rtde_port: int = 30004
    script_port: int = 30002
    timeout: float = 0.5


@dataclass
class UrDriver:
    """Driver of six joints, in the controller's order; the controller is in remote control.

    The robot is sent where a setpoint leads by the end of its period, so that it is there in time.
    Measurements have no torques and no contacts: the controller stops the robot where it feels one,
    and then the driver is lost.

    Attributes:
        address: Where the controller is.
        options: How it follows setpoints.
    """

    address: UrAddress
    options: ServoOptions = field(default_factory=ServoOptions)
    _connection: RtdeConnection | None = field(default=None, init=False)
    _epoch: float = field(default=0.0, init=False)

    @property
    def traits(self) -> DriverTraits:
        """Properties of the driver."""
        return DriverTraits(
            NAME, self.options.period, max_realtime_factor=1.0, rests_when_lost=False
        )

    def start(self) -> Measurement:
        """Connect, have the robot hold where it is by our program, and set the clock to 0.

        Raises:
            DriverLost: It does not answer, is not ready, or moves.
        """
        try:
            return self._started()
        except (ConnectionError, ValueError) as fault:
            raise self._lost(str(fault)) from fault

    def send(self, setpoint: Setpoint) -> None:
        """Send where the robot shall be a period after the setpoint's time."""
        period = self.options.period
        target = setpoint.q + period * setpoint.v + 0.5 * period**2 * setpoint.vdot
        connection = self._open
        try:
            connection.send(_inputs(SERVO, target))
        except (ConnectionError, ValueError) as fault:
            raise self._lost(str(fault)) from fault

    def read(self, time: float) -> Measurement:
        """Wait for the measurement at `time` [s] and return it, or the newest if more have come."""
        connection = self._open
        due = time - 0.5 * self.options.period
        try:
            values = connection.receive()
            while self._time(values) < due or connection.has_more():
                values = connection.receive()
        except (ConnectionError, ValueError) as fault:
            raise self._lost(str(fault)) from fault
        self._require_obedient(values)
        return self._measurement(values)

    def stop(self) -> None:
        """End the program, which brings the robot to rest, and disconnect."""
        if self._connection is None:
            return
        with suppress(ConnectionError, ValueError):
            self._connection.send(_inputs(IDLE, np.zeros(6)))
        self._connection.close()
        self._connection = None

    def _started(self) -> Measurement:
        address = self.address
        connection = RtdeConnection(address.host, address.rtde_port, address.timeout)
        self._connection = connection
        connection.set_up(self.options.frequency, _OUTPUTS, _INPUTS)
        values = connection.receive()
        self._require_safe(values)
        if np.abs(_vector(values, "actual_qd")).max() > _REST:
            raise self._lost("the robot moves already")
        here = _vector(values, "actual_q")
        # The program reads its target at once, so the target is there before the program.
        connection.send(_inputs(SERVO, here))
        self._send_program()
        for _ in range(int(10 * address.timeout * self.options.frequency)):
            values = connection.receive()
            if values[RUNNING] == 1:
                self._epoch = _number(values, "timestamp")
                self._require_obedient(values)
                return self._measurement(values)
        raise self._lost("its program does not run: is the controller in remote control?")

    def _send_program(self) -> None:
        address = (self.address.host, self.address.script_port)
        try:
            with socket.create_connection(address, timeout=self.address.timeout) as script:
                script.sendall(servo_program(self.options).encode("ascii"))
        except OSError as fault:
            message = f"cannot send the program to port {self.address.script_port}: {fault}"
            raise ConnectionError(message) from fault

    def _require_safe(self, values: dict[str, FieldValue]) -> None:
        mode = _number(values, "safety_mode")
        if mode not in _SAFE:
            raise self._lost(f"its safety mode is {mode:g}, neither normal nor reduced")

    def _require_obedient(self, values: dict[str, FieldValue]) -> None:
        self._require_safe(values)
        if values["runtime_state"] in _STOPPED or values[RUNNING] != 1:
            raise self._lost("its program has ended")

    def _measurement(self, values: dict[str, FieldValue]) -> Measurement:
        q, v = (_vector(values, name) for name in ("actual_q", "actual_qd"))
        return Measurement(self._time(values), q, v)

    def _time(self, values: dict[str, FieldValue]) -> float:
        return _number(values, "timestamp") - self._epoch

    @property
    def _open(self) -> RtdeConnection:
        if self._connection is None:
            raise self._lost("it was stopped")
        return self._connection

    def _lost(self, reason: str) -> DriverLost:
        self.stop()
        return driver_lost(NAME, reason, rests=False)


def _number(values: dict[str, FieldValue], name: str) -> float:
    value = values[name]
    return value[0] if isinstance(value, tuple) else value


def _vector(values: dict[str, FieldValue], name: str) -> Array:
    return np.atleast_1d(np.array(values[name], dtype=np.float64))


def _inputs(command: int, target: Array) -> dict[str, FieldValue]:
    return {COMMAND: command, **dict(zip(TARGETS, map(float, target), strict=True))}
