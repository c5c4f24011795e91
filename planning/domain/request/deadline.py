"""Deadline: how long there is, by whose clock, and whether anybody still wants the answer."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from planning.errors import Canceled, DeadlineExceeded


def _nobody_cancels() -> bool:
    return False


def _nothing() -> None:
    pass


@dataclass(frozen=True)
class Deadline:
    """An instant to be done by. The clock is an argument: nothing in `planning` reads its own.

    Attributes:
        allowed: The whole time [s].
        at: The instant, on `clock` [s].
        clock: Monotonic seconds.
        is_canceled: Asked at every check.
        on_cut: Called each time that work is told to end early because of the clock, so that what
            comes of it may be another time something else. Deadlines made of this one share it.
    """

    allowed: float
    at: float
    clock: Callable[[], float]
    is_canceled: Callable[[], bool] = _nobody_cancels
    on_cut: Callable[[], None] = _nothing

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
        return self.is_canceled() or self._is_late()

    def share(self, fraction: float) -> "Deadline":
        """Return a deadline after a fraction of what remains."""
        now = self.clock()
        left = max(0.0, self.at - now)
        return replace(self, at=now + fraction * left)

    def within(self, seconds: float | None) -> "Deadline":
        """Return the earlier of this deadline and that in so many seconds; None changes nothing."""
        if seconds is None:
            return self
        return replace(self, at=min(self.at, self.clock() + seconds))

    def limited(self, seconds: float) -> "Deadline":
        """Return the earlier of this deadline and one after so many seconds that are all allowed.

        Unlike `within` it is for the whole of some work, and failures say so.
        """
        at = self.clock() + seconds
        return self if self.at <= at else replace(self, allowed=seconds, at=at)

    @property
    def uncancelable(self) -> "Deadline":
        """The same instant, whoever does not want the answer any more."""
        return replace(self, is_canceled=_nobody_cancels)

    @property
    def over_when_canceled(self) -> "Deadline":
        """The same instant, and at once when somebody cancels: no error, but no time either."""

        def clock() -> float:
            return math.inf if self.is_canceled() else self.clock()

        return replace(self, clock=clock, is_canceled=_nobody_cancels)

    def cutting(self, on_cut: Callable[[], None]) -> "Deadline":
        """Return the same deadline, which calls `on_cut` each time that it cuts something."""
        return replace(self, on_cut=on_cut)

    def check(self, during: str) -> None:
        """Go on only if there is time.

        Raises:
            Canceled: The end was asked for.
            DeadlineExceeded: The time has run out.
        """
        if self.is_canceled():
            message = f"canceled during {during}"
            raise Canceled(message, {"during": during}).in_stage(during)
        if self._is_late():
            message = f"the allowed {self.allowed:g} s ran out during {during}"
            evidence = {"allowed": self.allowed, "during": during}
            raise DeadlineExceeded(message, evidence).in_stage(during)

    def _is_late(self) -> bool:
        is_late = self.clock() >= self.at
        if is_late:
            self.on_cut()
        return is_late


# For work that may take as long as it does.
UNHURRIED = Deadline(math.inf, math.inf, lambda: 0.0)
