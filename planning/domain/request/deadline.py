"""Deadline: time limit of a piece of work [s] on a clock that is an argument, with cancellation."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from planning.errors import Canceled, DeadlineExceeded


def _never_canceled() -> bool:
    return False


def _do_nothing() -> None:
    pass


@dataclass(frozen=True)
class Deadline:
    """Time limit with cancellation. The clock is an argument: nothing in `planning` reads its own.

    Attributes:
        time_limit: Total time that was allowed [s], for messages.
        expires_at: The instant, on `clock` [s].
        clock: Monotonic seconds.
        is_canceled: Returns whether the caller has canceled; called at every check.
        on_expiry: Called each time that a check ends work early because of the clock, since the
            same problem may then give another result in another run. Deadlines derived from this
            one share it.
    """

    time_limit: float
    expires_at: float
    clock: Callable[[], float]
    is_canceled: Callable[[], bool] = _never_canceled
    on_expiry: Callable[[], None] = _do_nothing

    @classmethod
    def after(
        cls,
        seconds: float,
        clock: Callable[[], float],
        is_canceled: Callable[[], bool] = _never_canceled,
    ) -> "Deadline":
        """Build the deadline that is `seconds` from now."""
        return cls(seconds, clock() + seconds, clock, is_canceled)

    @property
    def remaining(self) -> float:
        """Seconds left, never negative."""
        return max(0.0, self.expires_at - self.clock())

    @property
    def is_over(self) -> bool:
        """Whether the time has run out or the work is canceled."""
        return self.is_canceled() or self._is_expired()

    def at_fraction(self, fraction: float) -> "Deadline":
        """Return a deadline at a fraction of the remaining time."""
        now = self.clock()
        remaining = max(0.0, self.expires_at - now)
        return self._expiring(now + fraction * remaining)

    def within(self, seconds: float | None) -> "Deadline":
        """Return the earlier of this deadline and `seconds` from now; None leaves it unchanged."""
        if seconds is None:
            return self
        return self._expiring(min(self.expires_at, self.clock() + seconds))

    def limited(self, seconds: float) -> "Deadline":
        """Return the earlier of this deadline and a time limit of its own, `seconds` from now.

        Unlike `within` it sets `time_limit`, so failures report this limit as the whole time
        allowed.
        """
        at = self.clock() + seconds
        return self if self.expires_at <= at else replace(self, time_limit=seconds, expires_at=at)

    @property
    def uncancelable(self) -> "Deadline":
        """The same deadline without cancellation."""
        return replace(self, is_canceled=_never_canceled)

    @property
    def expired_when_canceled(self) -> "Deadline":
        """The same deadline, which a cancel ends at once: no error, but no time left."""

        def clock() -> float:
            return math.inf if self.is_canceled() else self.clock()

        return replace(self, clock=clock, is_canceled=_never_canceled)

    def with_on_expiry(self, on_expiry: Callable[[], None]) -> "Deadline":
        """Return the same deadline with another `on_expiry` callback."""
        return replace(self, on_expiry=on_expiry)

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
        if self._is_expired():
            message = f"the allowed {self.time_limit:g} s ran out during {during}"
            evidence = {"allowed": self.time_limit, "during": during}
            raise DeadlineExceeded(message, evidence).in_stage(during)

    def _expiring(self, at: float) -> "Deadline":
        """Return the same at another instant; every plan makes dozens, `replace` takes longer."""
        return Deadline(self.time_limit, at, self.clock, self.is_canceled, self.on_expiry)

    def _is_expired(self) -> bool:
        is_late = self.clock() >= self.expires_at
        if is_late:
            self.on_expiry()
        return is_late


# Deadline without a time limit.
NO_DEADLINE = Deadline(math.inf, math.inf, lambda: 0.0)
