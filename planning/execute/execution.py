"""Execution: state of a running trajectory and pure functions from measurements to setpoints.

No input or output happens here: `Runner` reads measurements and sends setpoints.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointLimits
from planning.domain.value import Value
from planning.errors import Contact, ExecutionFailure, ProblemInvalid, TrackingLost
from planning.execute.driver import Measurement, Setpoint
from planning.execute.states import ExecutionEvent, ExecutionState, advance
from planning.execute.status import ExecutionStatus
from planning.execute.time_scaling import choose_path_acceleration, path_acceleration_bounds
from planning.execute.tolerances import Tolerances

# Path velocities that differ by less are equal: rounding must not keep a robot from resting.
_PATH_VELOCITY_TOLERANCE = 1e-12


@dataclass(frozen=True, eq=False)
class Execution(Value):
    """Immutable state of the execution of one trajectory; every method returns the next state.

    Setpoints are continuous: pausing, canceling and changes of speed move along the trajectory's
    own path, with a path velocity that changes as quickly as the acceleration limits allow
    (see `time_scaling`). Only an abort leaves the path: the robot holds its measured position.

    Attributes:
        trajectory: Trajectory to follow.
        limits: Joint limits of the group; the acceleration limits hold while the path velocity
            changes.
        tolerances: Bounds on the tracking error and the conditions of arrival.
        state: State of the state machine.
        speed: Desired path velocity while executing, in (0, 1].
        time: Time along the trajectory [s].
        path_velocity: Present seconds of trajectory per second of the driver's clock.
        path_acceleration: Derivative of the path velocity until the next step [1/s].
        driver_time: Time of the last step, on the driver's clock [s].
        at_rest_since: Time from which setpoints are at rest, on the driver's clock [s]; None while
            they move.
        failure: Reason of an abort, or None.
    """

    trajectory: TimedTrajectory
    limits: JointLimits
    tolerances: Tolerances = field(default_factory=Tolerances)
    state: ExecutionState = ExecutionState.ACCEPTED
    speed: float = 1.0
    time: float = 0.0
    path_velocity: float = 0.0
    path_acceleration: float = 0.0
    driver_time: float = 0.0
    at_rest_since: float | None = None
    failure: ExecutionFailure | None = None

    def start(self) -> "Execution":
        """Begin to move.

        Raises:
            IllegalTransition: The execution has begun before.
        """
        # The trajectory starts at rest, so full speed at once is continuous in velocity.
        state = advance(self.state, ExecutionEvent.START)
        return replace(self, state=state, path_velocity=self.speed, at_rest_since=None)

    def pause(self) -> "Execution":
        """Come to rest on the path, until `resume`.

        Raises:
            IllegalTransition: The execution has not begun, is being canceled or has ended.
        """
        return replace(self, state=advance(self.state, ExecutionEvent.PAUSE))

    def resume(self) -> "Execution":
        """Continue a paused motion.

        Raises:
            IllegalTransition: The execution is neither paused nor executing.
        """
        state = advance(self.state, ExecutionEvent.RESUME)
        return replace(self, state=state, at_rest_since=None)

    def cancel(self) -> "Execution":
        """Come to rest on the path and end as canceled.

        Raises:
            IllegalTransition: The execution has ended.
        """
        return replace(self, state=advance(self.state, ExecutionEvent.CANCEL), at_rest_since=None)

    def with_speed(self, speed: float) -> "Execution":
        """Change the desired path velocity.

        Raises:
            ProblemInvalid: `speed` is not in (0, 1]: above 1 the limits would not hold.
            IllegalTransition: The execution has ended or is being canceled.
        """
        if not 0 < speed <= 1:
            message = f"speed must be above 0 and at most 1, got {speed}"
            raise ProblemInvalid(message, {"field": "speed"})
        return replace(self, state=advance(self.state, ExecutionEvent.SET_SPEED), speed=speed)

    def fail(self, failure: ExecutionFailure) -> "Execution":
        """Abort with a failure.

        Raises:
            IllegalTransition: The execution has ended.
        """
        state = advance(self.state, ExecutionEvent.FAIL)
        return replace(self, state=state, failure=failure, path_velocity=0.0, path_acceleration=0.0)

    def step(self, measured: Measurement, period: float) -> tuple["Execution", Setpoint]:
        """Check a measurement and compute the setpoint of the next `period` [s].

        Args:
            measured: Present measurement.
            period: Time until the next step [s], positive.

        Returns:
            The execution one period later and the setpoint to send; a terminal execution holds
            the robot.
        """
        checked = replace(self._checked(measured), driver_time=measured.time)
        if checked.state is ExecutionState.ABORTED:
            return checked, _hold_setpoint(measured.time, measured.q, len(measured.v))
        if checked.state.is_terminal:
            return checked, _hold_setpoint(measured.time, checked.desired, len(measured.v))
        return checked._advanced(period)  # noqa: SLF001  (its own class)

    def status(self, measured: Measurement) -> ExecutionStatus:
        """Return the status of the execution, given a measurement."""
        duration = self.trajectory.duration
        return ExecutionStatus(
            state=self.state,
            progress=self.time / duration if duration > 0 else 1.0,
            time=self.time,
            driver_time=measured.time,
            path_velocity=self.path_velocity,
            measured=measured.q,
            desired=self.desired,
            tracking_error=self.tracking_error(measured.q),
            contacts=measured.contacts,
            failure=self.failure,
        )

    @property
    def desired(self) -> Array:
        """Desired position of the group [rad or m], shape (nq,)."""
        return self.trajectory.positions(np.array([self.time]))[0]

    def tracking_error(self, q: Array) -> float:
        """Return the tracking error: the largest coordinate of `q [-] desired` [rad or m]."""
        return float(np.max(np.abs(self.trajectory.manifold.minus(q, self.desired))))

    def _checked(self, measured: Measurement) -> "Execution":
        """Return the execution after the events of a measurement: contact, lost tracking, rest."""
        if self.state.is_terminal:
            return self
        if measured.contacts:
            return self.fail(_contact_failure(measured))
        error = self.tracking_error(measured.q)
        if error > self.tolerances.tracking:
            return self.fail(_tracking_failure(error, self.tolerances.tracking, measured.time))
        if self.at_rest_since is None or self.state is ExecutionState.PAUSED:
            return self
        return self._settled(error, measured)

    def _settled(self, error: float, measured: Measurement) -> "Execution":
        """Return the execution while setpoints are at rest: arrived, still settling, or aborted."""
        bounds = self.tolerances
        is_at_rest = bool(np.max(np.abs(measured.v)) <= bounds.rest)
        is_at_goal = self.state is ExecutionState.CANCELING or error <= bounds.goal
        if is_at_rest and is_at_goal:
            is_canceling = self.state is ExecutionState.CANCELING
            event = ExecutionEvent.STOPPED if is_canceling else ExecutionEvent.SUCCEED
            return replace(self, state=advance(self.state, event))
        settling_time = measured.time - (self.at_rest_since or 0.0)
        if settling_time > bounds.settle_time:
            return self.fail(_tracking_failure(error, bounds.goal, measured.time))
        return self

    def _advanced(self, period: float) -> tuple["Execution", Setpoint]:
        """Return the execution one period later, and the setpoint until then."""
        path_acceleration = self._next_path_acceleration(period)
        path_velocity = self.path_velocity + path_acceleration * period
        if abs(path_velocity - self._target_path_velocity) < _PATH_VELOCITY_TOLERANCE:
            path_velocity = self._target_path_velocity
        step = 0.5 * (self.path_velocity + path_velocity) * period
        duration = self.trajectory.duration
        time = min(self.time + step, duration)
        has_ended = time >= duration
        is_at_rest = has_ended or (self._target_path_velocity == 0.0 and path_velocity == 0.0)
        at_rest_since = (
            self.at_rest_since if self.at_rest_since is not None else self.driver_time + period
        )
        advanced = replace(
            self,
            time=time,
            path_velocity=0.0 if has_ended else path_velocity,
            path_acceleration=path_acceleration,
            at_rest_since=at_rest_since if is_at_rest else None,
        )
        return advanced, self._setpoint(path_acceleration)

    def _setpoint(self, path_acceleration: float) -> Setpoint:
        times = np.array([self.time])
        velocity = self.trajectory.velocities(times)[0]
        acceleration = self.trajectory.accelerations(times)[0]
        is_over = self.time >= self.trajectory.duration
        path_velocity, path_acceleration = (
            (0.0, 0.0) if is_over else (self.path_velocity, path_acceleration)
        )
        vdot = acceleration * path_velocity**2 + velocity * path_acceleration
        return Setpoint(self.driver_time, self.desired, velocity * path_velocity, vdot)

    def _next_path_acceleration(self, period: float) -> float:
        """Return the path acceleration [1/s] during the next period."""
        if self.path_velocity == self._target_path_velocity:
            return 0.0
        max_path_acceleration = 1.0 / self.tolerances.ramp_time
        change = np.clip(
            self._target_path_velocity - self.path_velocity,
            -max_path_acceleration * period,
            max_path_acceleration * period,
        )
        end_time = min(self.time + self.path_velocity * period, self.trajectory.duration)
        # The limits must hold at the end of the period too, at the least and the largest velocity.
        times = np.array([self.time, end_time, end_time])
        velocities = self.path_velocity + np.array([0.0, 0.0, change])
        lower, upper = path_acceleration_bounds(self.trajectory, self.limits, times, velocities)
        bounds = max(lower, -max_path_acceleration), min(upper, max_path_acceleration)
        return choose_path_acceleration(
            bounds, self.path_velocity, self._target_path_velocity, period
        )

    @property
    def _target_path_velocity(self) -> float:
        return self.speed if self.state is ExecutionState.EXECUTING else 0.0


def _hold_setpoint(time: float, q: Array, num_velocities: int) -> Setpoint:
    return Setpoint(time, q, np.zeros(num_velocities), np.zeros(num_velocities))


def _contact_failure(measured: Measurement) -> Contact:
    deepest = measured.contacts[0]
    a, b = deepest.bodies
    depth = -deepest.distance
    message = f"contact of {a} and {b}, {depth * 1000:.2f} mm deep, at {measured.time:.3f} s"
    evidence = {"pair": list(deepest.bodies), "depth": depth, "time": measured.time}
    return Contact(message, evidence)


def _tracking_failure(error: float, bound: float, time: float) -> TrackingLost:
    message = f"tracking error {error:.4f} rad or m exceeds {bound:g} at {time:.3f} s"
    return TrackingLost(message, {"error": error, "bound": bound, "time": time})
