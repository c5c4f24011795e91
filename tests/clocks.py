"""Clocks for tests: none of them depends on how fast or how busy the machine is."""

from collections.abc import Callable
from dataclasses import dataclass

from planning.domain.request.deadline import Deadline


@dataclass
class FakeClock:
    """Seconds that pass when the test says so, or a little each time somebody looks.

    Attributes:
        now: What the clock shows [s].
        step: What passes at every look [s].
    """

    now: float = 0.0
    step: float = 0.0

    def __call__(self) -> float:
        self.now += self.step
        return self.now

    def advance(self, seconds: float) -> None:
        self.now += seconds


def _never() -> bool:
    return False


def no_hurry(seconds: float = 60.0, is_canceled: Callable[[], bool] = _never) -> Deadline:
    """Return a deadline that never comes: `seconds` remain for ever.

    What plans under it is the same on every machine. A planner that uses all its time would not
    end: give such a one a `FakeClock` with a step, or a number of iterations.
    """
    return Deadline.after(seconds, FakeClock(), is_canceled)


def after_looks(
    looks: int, is_canceled: Callable[[], bool] = _never, seconds: float = 1.0
) -> Deadline:
    """Return a deadline that comes when the clock has been looked at so many times."""
    return Deadline.after(seconds, FakeClock(step=seconds / looks), is_canceled)
