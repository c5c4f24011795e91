"""Execution: state of a running trajectory and pure functions from measurements to setpoints.

No input or output happens here: `Runner` reads measurements and sends setpoints.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointLimits
from planning.domain.value import Value
from planning.errors import ExecutionFailure, ProblemInvalid
from planning.execute.abort_reasons import (
    contact_failure,
    grasp_failure,
    saturated_block,
    torque_failure,
    tracking_failure,
)
from planning.execute.barrier import Barrier
from planning.execute.driver import Measurement, Setpoint
from planning.execute.path_motion import PathLimits, PathMotion
from planning.execute.states import ExecutionEvent, ExecutionState, advance
from planning.execute.status import ExecutionStatus
from planning.execute.tolerances import Tolerances


@dataclass(frozen=True, eq=False)
class Execution(Value):
    """Immutable state of the execution of one trajectory; every method returns the next state.

    Setpoints are continuous: pausing, canceling and changes of speed, backwards too, move along the
    trajectory's own path, with a path velocity that changes as quickly as the acceleration limits
    allow (see `time_scaling`). So does an abort while the robot follows its setpoints. A contact,
    and a robot that has left its trajectory, have the robot hold its measured position at once.

    Attributes:
        trajectory: Trajectory to follow; it rests at both ends.
        limits: Joint limits of the group; the acceleration limits hold while the path velocity
            changes.
        tolerances: Bounds on the tracking error and the conditions of arrival.
        state: State of the state machine.
        speed: Desired path velocity while executing, in [-1, 1]; negative is backwards.
        motion: Place and velocity along the trajectory.
        ahead: What it does not pass forwards: it rests before it until it is lifted; or None.
        behind: What it does not pass backwards, along the reversed trajectory; or None.
        driver_time: Time of the last step, on the driver's clock [s].
        at_rest_since: Time from which setpoints are at rest, on the driver's clock [s]; None while
            they move.
        saturated_since: Time from which some joint is at its torque limit, on the driver's clock
            [s]; None while none is.
        held: Position that an aborted motion holds, off the path, shape (nq,); None on the path.
        failure: Reason of an abort, or None.
    """

    trajectory: TimedTrajectory
    limits: JointLimits
    tolerances: Tolerances = field(default_factory=Tolerances)
    state: ExecutionState = ExecutionState.ACCEPTED
    speed: float = 1.0
    motion: PathMotion = field(default_factory=PathMotion)
    ahead: Barrier | None = None
    behind: Barrier | None = None
    driver_time: float = 0.0
    at_rest_since: float | None = None
    saturated_since: float | None = None
    held: Array | None = None
    failure: ExecutionFailure | None = None

    @property
    def time(self) -> float:
        """Time along the trajectory [s]."""
        return self.motion.time

    @property
    def path_velocity(self) -> float:
        """Present seconds of trajectory per second of the driver's clock; negative is backwards."""
        return self.motion.velocity

    def start(self) -> "Execution":
        """Begin to move.

        Raises:
            IllegalTransition: The execution has begun before.
        """
        # The trajectory starts at rest, so full speed at once is continuous in velocity.
        state = advance(self.state, ExecutionEvent.START)
        motion = replace(self.motion, velocity=max(0.0, self.speed))
        begun = replace(self, state=state, motion=motion, at_rest_since=None)
        return begun.between(None, self.ahead.time) if self.ahead is not None else begun

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
        """Come to rest on the path and end as canceled; an aborted motion stays aborted.

        Raises:
            IllegalTransition: The execution has ended.
        """
        state = advance(self.state, ExecutionEvent.CANCEL)
        if state is ExecutionState.ABORTING:
            return self
        return replace(self, state=state, at_rest_since=None)

    def with_speed(self, speed: float) -> "Execution":
        """Change the desired path velocity: 0 rests on the path, negative moves back along it.

        At the beginning of the path a motion backwards rests and waits; it never ends there.

        Raises:
            ProblemInvalid: `speed` is not in [-1, 1]: beyond, the limits would not hold.
            IllegalTransition: The execution has ended or is coming to its end.
        """
        if not -1 <= speed <= 1:
            message = f"speed must be at least -1 and at most 1, got {speed}"
            raise ProblemInvalid(message, {"field": "speed"})
        state = advance(self.state, ExecutionEvent.SET_SPEED)
        return replace(self, state=state, speed=speed, at_rest_since=None)

    def between(self, behind: float | None, ahead: float | None) -> "Execution":
        """Stay between two places of the path from now on, and rest before they are passed.

        A motion that is too quick to rest before a place rests as soon as the limits allow. One
        that rests before a place goes on by itself once that is lifted.

        Args:
            behind: Least place on the way back, time along the trajectory [s]; None for none.
            ahead: Largest place on the way forwards [s]; None for none.
        """
        kept = replace(
            self,
            behind=self._barrier(self.trajectory.reverse, behind, self.trajectory.duration),
            ahead=self._barrier(self.trajectory, ahead, 0.0),
            at_rest_since=None,
        )
        if kept.ahead is None or self.time > 0:
            return kept
        # At its start the trajectory rests, so the path velocity may be any.
        velocity = min(self.path_velocity, kept.ahead.max_speed(0.0))
        return replace(kept, motion=replace(self.motion, velocity=velocity))

    def _barrier(
        self, trajectory: TimedTrajectory, place: float | None, origin: float
    ) -> Barrier | None:
        """Return the barrier at a place that is counted from an origin [s]; None for none."""
        if place is None:
            return None
        rate = 1.0 / self.tolerances.ramp_time
        return Barrier.at(abs(place - origin), trajectory, self.limits, rate)

    def fail(self, failure: ExecutionFailure, held: Array | None = None) -> "Execution":
        """Abort with a failure, the first one if there are several.

        Args:
            failure: The reason.
            held: Position to hold at once, shape (nq,); None to come to rest on the path.

        Raises:
            IllegalTransition: The execution has ended.
        """
        state = advance(self.state, ExecutionEvent.FAIL)
        failed = replace(self, state=state, failure=self.failure or failure)
        if held is None:
            return failed if self.failure else replace(failed, at_rest_since=None)
        still = replace(self.motion, velocity=0.0, acceleration=0.0)
        return replace(failed, held=held, motion=still, at_rest_since=self.driver_time)

    def lose(self, failure: ExecutionFailure) -> "Execution":
        """End at once with a failure after which nothing can be sent to the robot.

        Raises:
            IllegalTransition: The execution has ended.
        """
        state = advance(self.state, ExecutionEvent.LOSE)
        still = replace(self.motion, velocity=0.0, acceleration=0.0)
        return replace(self, state=state, failure=self.failure or failure, motion=still)

    def step(self, measured: Measurement, period: float) -> tuple["Execution", Setpoint]:
        """Check a measurement and compute the setpoint of the next `period` [s].

        Args:
            measured: Present measurement.
            period: Time until the next step [s], positive.

        Returns:
            The execution one period later and the setpoint to send; a terminal execution holds
            the robot.
        """
        checked = replace(self, driver_time=measured.time)._checked(measured)  # noqa: SLF001
        if checked.held is not None or checked.state.is_terminal:
            q = checked.desired if checked.held is None else checked.held
            still = np.zeros(len(measured.v))
            return checked, Setpoint(measured.time, q, still, still)
        return checked._advanced(period)  # noqa: SLF001  (its own class)

    def status(self, measured: Measurement) -> ExecutionStatus:
        """Return the status of the execution, given a measurement."""
        return ExecutionStatus(
            state=self.state,
            progress=self.trajectory.path_fraction(self.time),
            time=self.time,
            driver_time=measured.time,
            path_velocity=self.path_velocity,
            measured=measured.q,
            velocities=measured.v,
            torques=measured.torques,
            desired=self.desired,
            tracking_error=self.tracking_error(measured.q),
            contacts=measured.contacts,
            held=measured.held,
            failure=self.failure,
            ahead=None if self.ahead is None else self.ahead.time,
            behind=None if self.behind is None else self.trajectory.duration - self.behind.time,
        )

    @property
    def desired(self) -> Array:
        """Desired position of the group [rad or m], shape (nq,)."""
        return self.trajectory.positions(np.array([self.time]))[0]

    def tracking_error(self, q: Array) -> float:
        """Return the tracking error: the largest coordinate of `q [-] desired` [rad or m]."""
        return float(np.max(np.abs(self.trajectory.manifold.minus(q, self.desired))))

    def _checked(self, measured: Measurement) -> "Execution":
        """Return the execution after the events of a measurement: failures, arrival, rest."""
        if self.state.is_terminal:
            return self
        error = self.tracking_error(measured.q)
        watched = self._watched(measured, error) if self.held is None else self
        if watched.failure is not None and self.failure is None:
            return watched  # what it does about it begins with this step
        return watched._settled(error, measured)  # noqa: SLF001

    def _watched(self, measured: Measurement, error: float) -> "Execution":
        """Return the execution, failed if the measurement allows no other way."""
        if measured.contacts:
            return self.fail(contact_failure(measured, self.time), held=measured.q)
        if error > self.tolerances.tracking:
            lost = tracking_failure(error, self.tolerances.tracking, self.time)
            return self.fail(lost, held=measured.q)
        if self.failure is None:
            for held in measured.held:
                if held.is_lost:
                    return self.fail(grasp_failure(held, self.time))
        if saturated_block(measured, self.limits) is None:
            return replace(self, saturated_since=None)
        since = measured.time if self.saturated_since is None else self.saturated_since
        watched, seconds = replace(self, saturated_since=since), measured.time - since
        if seconds <= self.tolerances.saturation_time or self.failure is not None:
            return watched
        joints = self.trajectory.joints
        return watched.fail(torque_failure(measured, self.limits, joints, seconds, self.time))

    def _settled(self, error: float, measured: Measurement) -> "Execution":
        """Return the execution while setpoints are at rest: ended, still settling, or aborted."""
        event = self._event_at_rest
        if self.at_rest_since is None or event is None:
            return self
        bounds = self.tolerances
        is_at_rest = bool(np.max(np.abs(measured.v)) <= bounds.rest)
        is_there = event is ExecutionEvent.STOPPED or error <= bounds.goal
        if is_at_rest and is_there:
            return replace(self, state=advance(self.state, event))
        if measured.time - self.at_rest_since <= bounds.settle_time:
            return self
        if self.state is ExecutionState.ABORTING:  # it does not get any better
            return replace(self, state=advance(self.state, ExecutionEvent.STOPPED))
        return self.fail(tracking_failure(error, bounds.goal, self.time))

    @property
    def _event_at_rest(self) -> ExecutionEvent | None:
        """What happens once the robot is at rest; None if it only waits on its path."""
        if self.state in {ExecutionState.CANCELING, ExecutionState.ABORTING}:
            return ExecutionEvent.STOPPED
        is_over = self.time >= self.trajectory.duration
        is_executing = self.state is ExecutionState.EXECUTING
        return ExecutionEvent.SUCCEED if is_executing and is_over else None

    def _advanced(self, period: float) -> tuple["Execution", Setpoint]:
        """Return the execution one period later, and the setpoint until then."""
        target = self.speed if self.state is ExecutionState.EXECUTING else 0.0
        rate = 1.0 / self.tolerances.ramp_time
        limits = PathLimits(self.limits, rate, self.ahead, self.behind)
        motion = self.motion.accelerated(self.trajectory, limits, target, period)
        setpoint = Setpoint(self.driver_time, self.desired, *motion.rates(self.trajectory))
        moved = motion.moved(self.trajectory.duration, target, period)
        if moved.velocity != 0.0:
            return replace(self, motion=moved, at_rest_since=None), setpoint
        since = self.driver_time + period if self.at_rest_since is None else self.at_rest_since
        return replace(self, motion=moved, at_rest_since=since), setpoint
