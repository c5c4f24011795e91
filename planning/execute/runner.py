"""Runner: control loop of an execution and a driver, stepped by the caller's clock."""

from collections.abc import Callable
from dataclasses import replace

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.geometry.touching_pair import worst_of_each
from planning.errors import ExecutionFailure, ProblemInvalid
from planning.execute.driver import Driver
from planning.execute.execution import Execution
from planning.execute.status import ExecutionStatus
from planning.execute.switch_motion import switch_motion


def _always() -> bool:
    return True


class Runner:
    """Control loop that reads the driver, steps the `Execution` and sends its setpoints.

    It has no clock and no thread: call `tick(now)` often. `speed` up to 1 slows the motion itself
    down along its path, negative moves it back. Beyond 1 the motion stays as it is and the driver's
    clock runs `speed` times as fast as the caller's, which only a simulation can do; either way the
    trajectory advances `speed` times as fast as real time.

    Attributes:
        execution: Present state of the execution.
        status: Status as of the last tick or command.
    """

    def __init__(
        self,
        execution: Execution,
        driver: Driver,
        *,
        max_catch_up: float = 0.25,
    ) -> None:
        """Connect an accepted execution to a driver, which is started.

        Args:
            execution: Execution to run, in state accepted.
            driver: Driver of the robot.
            max_catch_up: Longest gap that a late tick makes up for, on the caller's clock [s]; the
                rest of a longer gap is dropped, which bounds the steps of one tick. A robot paces
                its steps in `read`, which waits for it.

        Raises:
            DriverLost: The robot does not answer.
        """
        self.execution = execution
        self._driver = driver
        traits = driver.traits
        self._period = traits.period
        self._max_realtime_factor = traits.max_realtime_factor
        self._max_catch_up = max_catch_up
        self._realtime_factor = 1.0
        self._last_tick: float | None = None
        self._pending_time = 0.0
        self._measurement = driver.start()
        self._contacts = self._measurement.contacts
        self.status: ExecutionStatus = execution.status(self._measurement)

    @property
    def is_done(self) -> bool:
        """Whether the execution has ended."""
        return self.execution.state.is_terminal

    def start(self, now: float) -> ExecutionStatus:
        """Begin to move at `now` [s].

        Raises:
            IllegalTransition: The execution has begun before.
        """
        self.execution = self.execution.start()
        self._last_tick = now
        return self._report()

    def pause(self) -> ExecutionStatus:
        """Come to rest on the path; raises as `Execution.pause`."""
        self.execution = self.execution.pause()
        return self._report()

    def resume(self) -> ExecutionStatus:
        """Continue a paused motion; raises as `Execution.resume`."""
        self.execution = self.execution.resume()
        return self._report()

    def cancel(self) -> ExecutionStatus:
        """Come to rest on the path and end; raises as `Execution.cancel`."""
        self.execution = self.execution.cancel()
        return self._report()

    def abort(self, failure: ExecutionFailure) -> ExecutionStatus:
        """Come to rest on the path and end with a failure; raises as `Execution.fail`."""
        self.execution = self.execution.fail(failure)
        return self._report()

    def abort_at_once(self, failure: ExecutionFailure) -> ExecutionStatus:
        """Hold the measured position and end with a failure; raises as `Execution.fail`."""
        self.execution = self.execution.fail(failure, held=self._measurement.q)
        return self._report()

    def keep_between(self, behind: float | None, ahead: float | None) -> ExecutionStatus:
        """Stay between two places of the path; see `Execution.between`."""
        self.execution = self.execution.between(behind, ahead)
        return self._report()

    def switch_to(self, trajectory: TimedTrajectory, place: float) -> ExecutionStatus:
        """Go on along another motion; raises as `switch_motion`."""
        self.execution = switch_motion(self.execution, trajectory, place)
        return self._report()

    def set_speed(self, speed: float) -> ExecutionStatus:
        """Advance the trajectory `speed` times as fast as real time; negative is backwards.

        Raises:
            ProblemInvalid: The magnitude of `speed` exceeds the driver's largest.
            IllegalTransition: The execution has ended or is coming to its end.
        """
        most = self._max_realtime_factor
        if not -most <= speed <= most:
            message = f"speed must be at least -{most:g} and at most {most:g}, got {speed}"
            raise ProblemInvalid(message, {"field": "speed"})
        self.execution = self.execution.with_speed(min(max(speed, -1.0), 1.0))
        self._realtime_factor = max(abs(speed), 1.0)
        return self._report()

    def stop(self) -> None:
        """Let go of the robot; nothing can be run any more."""
        self._driver.stop()

    def tick(self, now: float, has_time: Callable[[], bool] = _always) -> ExecutionStatus:
        """Run all control periods that are due by `now` [s], and return the status.

        Args:
            now: Time on the caller's clock [s].
            has_time: Called after every period; if it returns False, the periods that are left run
                at the next tick. At a high speed a simulation may need seconds for the periods that
                are due, and the caller has to check meanwhile whether to stop.
        """
        self._contacts = ()
        elapsed = 0.0 if self._last_tick is None else max(0.0, now - self._last_tick)
        self._last_tick = now
        self._pending_time = min(
            self._pending_time + elapsed * self._realtime_factor,
            self._max_catch_up * self._realtime_factor,
        )
        # Rounding must not delay a step by a whole tick.
        while self._pending_time >= self._period * (1 - 1e-9) and not self.is_done:
            self._pending_time -= self._period
            self._step()
            if not has_time():
                break
        return self._report()

    def _step(self) -> None:
        self.execution, setpoint = self.execution.step(self._measurement, self._period)
        try:
            self._driver.send(setpoint)
            if not self.is_done:
                self._measurement = self._driver.read(self._measurement.time + self._period)
                self._contacts += self._measurement.contacts
        except ExecutionFailure as failure:
            if not self.is_done:
                self.execution = self.execution.lose(failure)

    def _report(self) -> ExecutionStatus:
        contacts = worst_of_each(self._contacts)
        self.status = self.execution.status(replace(self._measurement, contacts=contacts))
        return self.status
