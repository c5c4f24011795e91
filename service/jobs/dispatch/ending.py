"""Ending: what becomes of a job whose run returned no result."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from planning.errors import WayproofError
from service.jobs.outcome import (
    Crashed,
    Failed,
    Silent,
    Terminated,
    error_of,
    interrupted,
    with_stage,
)


@dataclass(frozen=True)
class Ending:
    """The end of a run without a result.

    Attributes:
        outcome: Of the run.
        attempts: How often the job was started.
        max_attempts: How often it may be.
        is_cancel_requested: Whether its end was requested.
        interruption: Why the server ended it; empty if it did not.
    """

    outcome: Failed
    attempts: int
    max_attempts: int
    is_cancel_requested: bool
    interruption: str

    @property
    def requeue(self) -> Mapping[str, Any] | None:
        """How the job is queued again: the reason and a refund of attempts; None if it is not."""
        if self.is_cancel_requested:
            return None
        if self.interruption:
            again = {"reason": self.interruption, "refund": 1}
            return again if self.max_attempts > 1 else None
        if isinstance(self.outcome, Crashed | Silent) and self.attempts < self.max_attempts:
            return {"reason": error_of(self.outcome, self.attempts).detail}
        return None

    def error(self, stage_event: Mapping[str, Any], seconds: float) -> WayproofError:
        """Return what the job shows.

        Args:
            stage_event: The last event of its stages, or nothing.
            seconds: How long it ran.
        """
        outcome = self.outcome
        is_crash = isinstance(outcome, Crashed | Silent)
        if self.is_cancel_requested and self.max_attempts > 1 and is_crash:
            outcome = Terminated()
        error = with_stage(error_of(outcome, self.attempts), stage_event, seconds)
        if not self.interruption or self.is_cancel_requested:
            return error
        return interrupted(outcome, error, self.interruption, self.attempts)
