"""Runner: an execution and a driver, moved on by whoever has the clock."""

from collections.abc import Callable

from planning.errors import ExecutionFailure, ProblemInvalid
from planning.execute.driver import Driver
from planning.execute.execution import Execution
from planning.execute.status import ExecutionStatus

MAX_PACE = 100.0


def _always() -> bool:
    return True


class Runner:
    """Does what an `Execution` decides. It has no clock and no thread: call `tick(now)` often.

    `speed` up to 1 slows the motion itself down along its path. Beyond 1 the motion stays as it
    is and the driver's clock runs `speed` times as fast as the caller's, which only a simulation
    can do; either way the trajectory advances `speed` times as fast as real time.

    Attributes:
        execution: As it stands.
        status: As of the last tick.
    """

    def __init__(
        self,
        execution: Execution,
        driver: Driver,
        *,
        period: float = 0.004,
        max_catch_up: float = 0.25,
        max_pace: float = MAX_PACE,
    ) -> None:
        """Take an accepted execution and the driver that will move.

        Args:
            execution: What to do.
            driver: What does it; its clock stands at 0.
            period: Between setpoints, on the driver's clock [s].
            max_catch_up: What a late tick makes up for at most, on the driver's clock [s] times
                the pace; the rest of a longer gap is dropped, so a tick never works for long.
            max_pace: How much faster than the caller's clock the driver's may run; 1 for a robot.
        """
        self.execution = execution
        self._driver = driver
        self._period = period
        self._max_catch_up = max_catch_up
        self._max_pace = max_pace
        self._pace = 1.0
        self._last_tick: float | None = None
        self._owed = 0.0
        self._measured = driver.read(0.0)
        self.status: ExecutionStatus = execution.status(self._measured)

    @property
    def is_done(self) -> bool:
        """Whether the execution has ended."""
        return self.execution.state.is_terminal

    def start(self, now: float) -> ExecutionStatus:
        """Begin to move at `now` [s].

        Raises:
            IllegalTransition: It began before.
        """
        self.execution = self.execution.start()
        self._last_tick = now
        return self._report()

    def pause(self) -> ExecutionStatus:
        """Come to rest on the path; raises as `Execution.pause`."""
        self.execution = self.execution.pause()
        return self._report()

    def resume(self) -> ExecutionStatus:
        """Move on; raises as `Execution.resume`."""
        self.execution = self.execution.resume()
        return self._report()

    def cancel(self) -> ExecutionStatus:
        """Come to rest on the path and end; raises as `Execution.cancel`."""
        self.execution = self.execution.cancel()
        return self._report()

    def set_speed(self, speed: float) -> ExecutionStatus:
        """Advance the trajectory `speed` times as fast as real time.

        Raises:
            ProblemInvalid: `speed` is not above 0, or beyond what the driver can do.
        """
        if not 0 < speed <= self._max_pace:
            message = f"speed must be above 0 and at most {self._max_pace:g}, got {speed}"
            raise ProblemInvalid(message, {"field": "speed"})
        self.execution = self.execution.with_speed(min(speed, 1.0))
        self._pace = max(speed, 1.0)
        return self._report()

    def tick(self, now: float, has_time: Callable[[], bool] = _always) -> ExecutionStatus:
        """Do what is due by `now` [s] on the caller's clock, and return how it goes.

        Args:
            now: On the caller's clock [s].
            has_time: Asked after every step; if not, what is left is done at the next tick. At a
                high speed a simulation needs seconds for what is due, and the caller has to look
                meanwhile whether it is to stop.
        """
        elapsed = 0.0 if self._last_tick is None else max(0.0, now - self._last_tick)
        self._last_tick = now
        self._owed = min(self._owed + elapsed * self._pace, self._max_catch_up * self._pace)
        # Rounding must not delay a step by a whole tick.
        while self._owed >= self._period * (1 - 1e-9) and not self.is_done:
            self._owed -= self._period
            self._step()
            if not has_time():
                break
        return self._report()

    def _step(self) -> None:
        self.execution, setpoint = self.execution.step(self._measured, self._period)
        try:
            self._driver.send(setpoint)
            if not self.is_done:
                self._measured = self._driver.read(self._measured.time + self._period)
        except ExecutionFailure as failure:
            self.execution = self.execution.fail(failure)

    def _report(self) -> ExecutionStatus:
        self.status = self.execution.status(self._measured)
        return self.status
