"""Termination: whether, why and how a run is to end."""

import asyncio
from collections.abc import Callable

from service.jobs.outcome import Crashed, Outcome, Raised, Silent, Terminated, TimedOut

# How long a task that ran out of time may take to end by itself [s].
DEADLINE_GRACE = 0.25
# How often a run is checked within the longest silence that it may keep.
_CHECKS_PER_SILENCE = 4


class Termination:
    """Deadline, cancel and silence of one run: it is told to end, and if it does not, killed."""

    def __init__(self, time_limit: float | None) -> None:
        """Let it run.

        Args:
            time_limit: For how long, from `begin` on [s]; None without a limit.
        """
        self.is_canceled = False
        self._is_late = False
        self._is_silent = False
        self._time_limit = time_limit
        self._grace = 0.0
        self._silence: float | None = None
        self._num_silent_checks = 0
        self._deadline_timer: asyncio.TimerHandle | None = None
        self._silence_timer: asyncio.TimerHandle | None = None
        self._kill_timer: asyncio.TimerHandle | None = None
        self._ask: Callable[[], None] | None = None
        self._kill: Callable[[], None] | None = None

    def begin(self, ask: Callable[[], None], kill: Callable[[], None]) -> None:
        """Count the time from now on, and know how to end the run."""
        self._ask, self._kill = ask, kill
        if self._time_limit is not None:
            self.set_deadline(self._time_limit)

    def set_deadline(self, seconds: float, grace: float = 0.0) -> None:
        """Let it run for so long from now on, whatever the limit was; too late if it is to end.

        Args:
            seconds: Time that it may take [s].
            grace: Time beyond it in which it is not told to end yet [s].
        """
        if self._ask is None or self.is_canceled or self._is_late:
            return
        if self._deadline_timer is not None:
            self._deadline_timer.cancel()
        self._time_limit, self._grace = seconds, grace
        self._deadline_timer = _after(seconds + grace, self._on_deadline)

    def limit_silence(self, silence: float) -> None:
        """End the run by force once it has said nothing for so long [s], even if it is to end."""
        if self._ask is None:
            return
        self._silence = silence
        self.heard()
        if self._silence_timer is not None:
            self._silence_timer.cancel()
        self._silence_timer = _after(silence / _CHECKS_PER_SILENCE, self._check_silence)

    def heard(self) -> None:
        """Note that the run has said something."""
        self._num_silent_checks = 0

    def cancel(self, grace: float) -> None:
        """End the run on request; asking again changes nothing."""
        if not self.is_canceled:
            self.is_canceled = True
            if not self._is_late:
                self._terminate(grace)

    def disarm(self) -> None:
        """Do no more; the run has ended."""
        self._ask = None
        for timer in (self._deadline_timer, self._silence_timer, self._kill_timer):
            if timer is not None:
                timer.cancel()

    def classify(self, outcome: Raised | Crashed) -> Outcome:
        """Return what an end without a result means if the run was to end."""
        if self._is_silent and isinstance(outcome, Crashed):
            return Silent(self._silence or 0.0)
        if self._is_late:
            said = outcome.error if isinstance(outcome, Raised) else None
            return TimedOut(self._time_limit or 0.0, said, self._grace)
        if not self.is_canceled:
            return outcome
        if isinstance(outcome, Raised):
            return Terminated(outcome.error)
        # What moves a robot has not ended as it should if it died on the way to rest.
        return Terminated() if self._silence is None else outcome

    def _on_deadline(self) -> None:
        # What was canceled before keeps the grace that it was given.
        if not self.is_canceled:
            self._is_late = True
            self._terminate(DEADLINE_GRACE)

    def _check_silence(self) -> None:
        # Checks are counted, not seconds: while this loop itself stood still, it heard nothing.
        self._num_silent_checks += 1
        if self._silence is None or self._kill is None:
            return
        if self._num_silent_checks > _CHECKS_PER_SILENCE:
            self._is_silent = True
            self._kill()
        else:
            self._silence_timer = _after(self._silence / _CHECKS_PER_SILENCE, self._check_silence)

    def _terminate(self, grace: float) -> None:
        if self._ask is not None and self._kill is not None:
            self._ask()
            self._kill_timer = _after(grace, self._kill)


def _after(seconds: float, act: Callable[[], None]) -> asyncio.TimerHandle:
    return asyncio.get_running_loop().call_later(seconds, act)
