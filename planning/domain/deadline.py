"""Deadline: how long there is, by whose clock, and whether anybody still wants the answer."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from planning.errors import Canceled, DeadlineExceeded


def _nobody_cancels() -> bool:
    return False


@dataclass(frozen=True)
class Deadline:
    """An instant to be done by. The clock is an argument: nothing in `planning` reads its own.

    Attributes:
        allowed: The whole time [s].
        at: The instant, on `clock` [s].
        clock: Monotonic seconds.
        is_canceled: Asked at every check.
    """

    allowed: float
    at: float
    clock: Callable[[], float]
    is_canceled: Callable[[], bool] = _nobody_cancels

    @classmethod
    def after(
        cls,
        seconds: float,
        clock: Callable[[], float],
        is_canceled: Callable[[], bool] = _nobody_cancels,
    ) -> "Deadline":
        """Build the deadline that is `seconds` from now."""
        return cls(seconds, clock() + seconds, clock, is_canceled)

    @property
    def remaining(self) -> float:
        """Seconds left, never negative."""
        return max(0.0, self.at - self.clock())

    @property
    def is_over(self) -> bool:
        """Whether it is too late, or nobody wants the answer any more."""
        return self.is_canceled() or self.clock() >= self.at

    def share(self, fraction: float) -> "Deadline":
        """Return a deadline after a fraction of what remains."""
        now = self.clock()
        left = max(0.0, self.at - now)
        return Deadline(self.allowed, now + fraction * left, self.clock, self.is_canceled)

    def within(self, seconds: float | None) -> "Deadline":
        """Return the earlier of this deadline and that in so many seconds; None changes nothing."""
        if seconds is None:
            return self
        at = min(self.at, self.clock() + seconds)
        return Deadline(self.allowed, at, self.clock, self.is_canceled)

    @property
    def uncancelable(self) -> "Deadline":
        """The same instant, whoever does not want the answer any more."""
        return Deadline(self.allowed, self.at, self.clock)

    @property
    def over_when_canceled(self) -> "Deadline":
        """The same instant, and at once when somebody cancels: no error, but no time either."""

        def clock() -> float:
            return math.inf if self.is_canceled() else self.clock()

        return Deadline(self.allowed, self.at, clock)

    def check(self, during: str) -> None:
        """Go on only if there is time.

        Raises:
            Canceled: Somebody asked for the end.
            DeadlineExceeded: The time has run out.
        """
        if self.is_canceled():
            message = f"canceled during {during}"
            raise Canceled(message, {"during": during})
        if self.clock() >= self.at:
            message = f"the allowed {self.allowed:g} s ran out during {during}"
            raise DeadlineExceeded(message, {"allowed": self.allowed, "during": during})
