"""Stop: whether, why and how a run is to end."""

import asyncio
from collections.abc import Callable

from service.jobs.outcome import Crashed, Ended, Outcome, Raised, TimedOut

# How long a task that ran out of time may take to end by itself [s].
DEADLINE_GRACE = 0.25


class Stop:
    """First a run is told to end, and if it has not ended in time it is made to."""

    def __init__(self, allowed: float | None) -> None:
        """Let it run.

        Args:
            allowed: For how long, from `begin` on [s]; None for ever.
        """
        self.is_canceled = False
        self._is_late = False
        self._allowed = allowed
        self._timers: list[asyncio.TimerHandle] = []
        self._term: asyncio.TimerHandle | None = None
        self._tell: Callable[[], None] | None = None
        self._force: Callable[[], None] | None = None

    def begin(self, tell: Callable[[], None], force: Callable[[], None]) -> None:
        """Count the time from now on, and know how to end the run."""
        self._tell, self._force = tell, force
        if self._allowed is not None:
            self.allow(self._allowed)

    def allow(self, seconds: float) -> None:
        """Let it run for so long from now on, whatever was said before; too late if it is to end.

        Args:
            seconds: [s].
        """
        if self._tell is None or self.is_canceled or self._is_late:
            return
        if self._term is not None:
            self._term.cancel()
        self._allowed = seconds
        self._term = self._after(seconds, self._overrun)

    def cancel(self, grace: float) -> None:
        """End the run on request; asking again changes nothing."""
        if not self.is_canceled:
            self.is_canceled = True
            self._press(grace)

    def disarm(self) -> None:
        """Do no more; the run has ended."""
        self._tell = None
        for timer in self._timers:
            timer.cancel()

    def verdict(self, outcome: Raised | Crashed) -> Outcome:
        """Return what an end without a result means if the run was to end."""
        if self._is_late:
            return TimedOut(self._allowed or 0.0)
        if self.is_canceled:
            return Ended(outcome.error if isinstance(outcome, Raised) else None)
        return outcome

    def _overrun(self) -> None:
        self._is_late = not self.is_canceled
        self._press(DEADLINE_GRACE)

    def _press(self, grace: float) -> None:
        if self._tell is not None and self._force is not None:
            self._tell()
            self._after(grace, self._force)

    def _after(self, seconds: float, act: Callable[[], None]) -> asyncio.TimerHandle:
        timer = asyncio.get_running_loop().call_later(seconds, act)
        self._timers.append(timer)
        return timer
