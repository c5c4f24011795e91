"""Deadline: time limit of a piece of work [s] on a clock that is an argument, with cancellation."""

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
    """Time limit with cancellation. The clock is an argument: nothing in `planning` reads its own.

    Attributes:
        allowed: Total time that was allowed [s], for messages.
        at: The instant, on `clock` [s].
        clock: Monotonic seconds.
        is_canceled: Returns whether the caller has canceled; called at every check.
        on_cut: Called each time that a check ends work early because of the clock, since the same
            problem may then give another result in another run. Deadlines derived from this one
            share it.
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
        """Whether the time has run out or the work is canceled."""
        return self.is_canceled() or self._is_late()

    def share(self, fraction: float) -> "Deadline":
        """Return a deadline at a fraction of the remaining time."""
        now = self.clock()
        left = max(0.0, self.at - now)
        return replace(self, at=now + fraction * left)

    def within(self, seconds: float | None) -> "Deadline":
        """Return the earlier of this deadline and `seconds` from now; None leaves it unchanged."""
        if seconds is None:
            return self
        return replace(self, at=min(self.at, self.clock() + seconds))

    def limited(self, seconds: float) -> "Deadline":
        """Return the earlier of this deadline and a time limit of its own, `seconds` from now.

        Unlike `within` it sets `allowed`, so failures report this limit as the whole time allowed.
        """
        at = self.clock() + seconds
        return self if self.at <= at else replace(self, allowed=seconds, at=at)

    @property
    def uncancelable(self) -> "Deadline":
        """The same deadline without cancellation."""
        return replace(self, is_canceled=_nobody_cancels)

    @property
    def over_when_canceled(self) -> "Deadline":
        """The same deadline, which a cancel ends at once: no error, but no time left."""

        def clock() -> float:
            return math.inf if self.is_canceled() else self.clock()

        return replace(self, clock=clock, is_canceled=_nobody_cancels)

    def cutting(self, on_cut: Callable[[], None]) -> "Deadline":
        """Return the same deadline with another `on_cut` callback."""
        return replace(self, on_cut=on_cut)

    def check(self, during: str) -> None:
        """Raise if the work must end now.

        Args:
            during: Name of the work, for the failure.

        Raises:
            Canceled: The work is canceled.
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


# Deadline without a time limit.
UNHURRIED = Deadline(math.inf, math.inf, lambda: 0.0)
