"""AttemptEnd: writes what became of a run into the table: its end, or that the job runs again."""

import json
import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from planning.errors import Canceled, WayproofError
from service.jobs.dispatch.lost_hosts import is_mere_cancel, runs_elsewhere
from service.jobs.dispatch.recorder import JobRecorder
from service.jobs.errors import DatabaseTaken, InternalError
from service.jobs.job import Job, JobText, PendingEvent
from service.jobs.json_text import Encoded
from service.jobs.outcome import (
    Crashed,
    Failed,
    Lost,
    Outcome,
    Raised,
    Returned,
    Silent,
    Terminated,
    error_of,
    interrupted,
    is_deterministic,
    with_stage,
)
from service.jobs.store.transitions import Transition, ended_job

_log = logging.getLogger(__name__)


@dataclass
class StopRequest:
    """Why a run is to end before it is done; it may come while the end is written.

    Attributes:
        is_cancel: Whether a client requests it.
        interruption: Why the server has to end it; empty if it need not.
    """

    is_cancel: bool
    interruption: str = ""


@dataclass
class AttemptEnd:
    """The end of one run of a job.

    Attributes:
        job: As it was queued.
        recorder: Writes it.
        stop: Why it was to end.
        attempts: How often the job was started by now.
        num_lost_hosts: How many machines were lost under it.
        seconds: How long the task ran.
        stage: Data of its last event `stage`, recorded or not.
        pending_events: That are not recorded yet.
        ended: The job as the table has it, once it has ended.
    """

    job: Job
    recorder: JobRecorder
    stop: StopRequest
    attempts: int
    num_lost_hosts: int
    seconds: float
    stage: dict[str, Any]
    pending_events: Sequence[PendingEvent]
    ended: JobText | None = None

    async def write(self, outcome: Outcome) -> bool:
        """Write it, however long that takes; return whether the job is queued again instead."""
        identifier = self.job.id
        write = partial(self._write_once, outcome)
        try:
            return await self.recorder.write_until_done(identifier, "end", write)
        except DatabaseTaken:
            return False
        except Exception as fault:
            if self.pending_events:
                _log.exception("%d events of %s were lost", len(self.pending_events), identifier)
                self.pending_events = []
                return await self.write(outcome)
            # The database is well: it is what the task gave that it does not take.
            if isinstance(outcome, Raised) and isinstance(outcome.error, InternalError):
                raise
            _log.exception("the end of %s could not be written", identifier)
            reason = f"the result could not be recorded: {type(fault).__name__}"
            return await self.write(Raised(InternalError(reason)))

    async def _write_once(self, outcome: Outcome) -> bool:
        """Write the end, and return whether the job is queued again instead."""
        store, identifier = self.recorder.store, self.job.id
        if isinstance(outcome, Returned):
            result = outcome.result
            summary = json.loads((outcome.summary or result).text)
            # It writes the last events itself, which saves two statements of six.
            last = self.pending_events
            succeed = partial(store.succeed, identifier, result, outcome.summary, last)
            is_durable = self._must_be_durable(summary)
            end = await self._apply(succeed, events=(), is_durable=is_durable)
            self._keep_end(end, result, summary)
            return False
        requeue = self._requeue(outcome)
        if requeue is not None:
            queued = await self._apply(requeue)
            if queued is None or not (queued.is_cancel_requested or self.stop.is_cancel):
                return queued is not None
            outcome = Terminated()
        error = self._error(outcome)
        is_canceled = isinstance(error, Canceled)
        cancel = partial(store.cancel, identifier, error) if is_canceled else None
        self._keep_end(await self._apply(cancel or partial(store.fail, identifier, error)))
        return False

    def _must_be_durable(self, summary: Any) -> bool:
        """Return whether a power cut must not take a result back, which would be made again."""
        return self.job.max_attempts == 1 or not is_deterministic(summary)

    def _keep_end(
        self, end: Transition | None, result: Encoded | None = None, summary: Any = None
    ) -> None:
        """Keep the job as it would be read, for those who wait for it."""
        if end is not None:
            made_by = self.recorder.store.versions
            self.ended = ended_job(end, self.job.payload, made_by, result, summary)

    def _requeue(self, outcome: Failed) -> Callable[[], Transition | None] | None:
        """Return how to queue the job again if it is to run again, else None."""
        requeue = partial(self.recorder.store.requeue, self.job.id)
        if self.stop.is_cancel:
            return None
        if self.stop.interruption:
            again = partial(requeue, self.stop.interruption, refund=1)
            return again if self.job.max_attempts > 1 else None
        if isinstance(outcome, Lost):
            again = partial(requeue, error_of(outcome, self.attempts).detail, refund=1)
            return again if runs_elsewhere(outcome, self.job, self.num_lost_hosts) else None
        if isinstance(outcome, Crashed | Silent) and self.attempts < self.job.max_attempts:
            return partial(requeue, error_of(outcome, self.attempts).detail)
        return None

    def _error(self, outcome: Failed) -> WayproofError:
        """Return what the job shows for an end without a result."""
        if self.stop.is_cancel and is_mere_cancel(outcome, self.job):
            outcome = Terminated()
        error = with_stage(error_of(outcome, self.attempts), self.stage, self.seconds)
        if not self.stop.interruption or self.stop.is_cancel:
            return error
        return interrupted(outcome, error, self.stop.interruption, self.attempts)

    async def _apply(
        self,
        change: Callable[[], Transition | None],
        *,
        events: Sequence[PendingEvent] | None = None,
        is_durable: bool = True,
    ) -> Transition | None:
        """Write a transition of the job, with its last events unless others are given."""
        before = self.pending_events if events is None else events
        apply = partial(self.recorder.apply, self.job.id, change, events=before)
        transition = await apply(is_durable=is_durable, is_owed=True)
        self.pending_events = []
        return transition
