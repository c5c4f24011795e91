"""Attempt: one run of a job, from the queue to its end in the table."""

import asyncio
import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from typing import Any

from planning.errors import Canceled, WayproofError
from service.jobs.dispatch.attempt_end import AttemptEnd, StopRequest
from service.jobs.dispatch.conclusion import Conclusion
from service.jobs.dispatch.crash import Run, note_crash
from service.jobs.dispatch.recorder import JobRecorder
from service.jobs.dispatch.scheduling.scheduler import Scheduler
from service.jobs.dispatch.spans import run_traced
from service.jobs.errors import DatabaseTaken, InternalError
from service.jobs.event_buffer import EventBuffer
from service.jobs.job import Job, JobText, PendingEvent
from service.jobs.json_text import Encoded, encode
from service.jobs.outcome import Lost, Outcome, Raised, Returned, Terminated
from service.jobs.states import JobState
from service.jobs.store.transitions import Transition
from service.jobs.task import artifacts_of
from service.jobs.worker.assignment import Assignment, Worker
from service.telemetry.ids import JOB, bind_ids, bound_ids

# How long to wait before the start of a job is written again after the database refused it [s].
_RETRY_PERIOD = 5.0
_log = logging.getLogger(__name__)


class Attempt:
    """Runs a job once; the dispatcher queues it again if `run` says so.

    It hears of everything in memory, at once; what the database has of it may come later.

    Attributes:
        job: As it was queued.
        controls: That are set, to be passed to the task.
        has_begun: Whether it was given a worker.
        has_start_to_write: Whether the worker has all that it needs, so that it will run there.
        cancel_requested_at: When its end was requested (UTC), if it was.
        concluded: Set once its end is in the table, or another server has the job.
        ended: The job as the table has it, once it has ended in this attempt.
        num_lost_hosts: How many machines were lost under the job since this server took it up.
        ids: Of the job, and of the request that it was made for, for the log.
    """

    def __init__(
        self,
        job: Job,
        recorder: JobRecorder,
        scheduler: Scheduler,
        controls: Mapping[str, Any],
        conclusion: Conclusion,
        text: str | None = None,
    ) -> None:
        """Prepare to run a queued job.

        Args:
            job: The job.
            recorder: Writes what happens to it.
            scheduler: Has workers.
            controls: That are set.
            conclusion: What is done before its end is recorded.
            text: Its payload as JSON, if that is known.
        """
        self._conclusion = conclusion
        self.job = job
        self.controls = dict(controls)
        self._text = text
        self.has_begun = False
        self.concluded = asyncio.Event()
        self.ended: JobText | None = None
        self.num_lost_hosts = 0
        self.ids = {**bound_ids(), JOB: job.id}
        self._recorder = recorder
        self._scheduler = scheduler
        self._events = EventBuffer(self._write_events)
        self._worker: Worker | None = None
        self._is_confirmed = asyncio.Event()
        self._is_discarded = False
        self._stop = StopRequest(job.is_cancel_requested)
        self.cancel_requested_at = job.cancel_requested_at
        self._start: Transition | None = None
        self._written_start: Transition | None = None
        self.has_start_to_write = False
        self._start_is_decided = asyncio.Event()
        self._has_ended = False
        self._seconds = 0.0

    @property
    def is_cancel_requested(self) -> bool:
        """Whether its end was requested."""
        return self._stop.is_cancel

    @property
    def is_starting(self) -> bool:
        """Whether it was given a worker, and the table does not know."""
        return self.has_begun and not self._start_is_decided.is_set()

    @property
    def is_open(self) -> bool:
        """Whether it still takes controls."""
        return not (self._stop.is_cancel or self._has_ended)

    @property
    def grace(self) -> float:
        """How long it may take to end once it is told to [s]."""
        # A task that has something to give on a cancel says how long it needs for that.
        usual = self._scheduler.queue(self.job.queue).cancel_grace
        return float(self.job.payload.get("cancel_grace", usual))

    @property
    def unrecorded(self) -> list[str]:
        """What has happened and is not in the database yet."""
        known = self._recorder.unrecorded(self.job.id)
        own = {"events": self._events.is_refused, "end": self._has_ended}
        return list(dict.fromkeys([*known, *(what for what, is_so in own.items() if is_so)]))

    def confirm(self, job: Job, start: Transition | None = None) -> None:
        """Record what happens from now on.

        Args:
            job: As the table has it.
            start: Its start, if that was written with it.
        """
        self.job = job
        self._written_start = start
        self._is_confirmed.set()

    def discard(self) -> None:
        """End the run, and record nothing of it: the table will never have the job."""
        self._is_discarded = True
        self._is_confirmed.set()
        self.cancel()

    def cancel(self) -> None:
        """End the run on request, whatever it does."""
        self._stop.is_cancel = True
        self.cancel_requested_at = self.cancel_requested_at or datetime.now(UTC)
        self._terminate()

    def interrupt(self, reason: str) -> None:
        """End the run because the server has to; the job is queued again if it may run again."""
        self._stop.interruption = self._stop.interruption or reason
        self._terminate()

    def control(self, controls: Mapping[str, Any]) -> None:
        """Set controls of the run; those of other names stay."""
        self.controls |= controls
        if self._worker is not None:
            self._worker.control(self.controls)

    async def record_events(self) -> None:
        """Record what the run has told so far: clients may have read it already."""
        await self._events.flush()

    def latest(self, event_type: str) -> dict[str, Any] | None:
        """Return the data of the last event of a type, recorded or not."""
        data = self._events.latest.get(event_type)
        return None if data is None else json.loads(data.text)

    def snapshot(self) -> Job:
        """Return the job as memory has it."""
        at, is_requested = self.cancel_requested_at, self._stop.is_cancel
        job = replace(self.job, is_cancel_requested=is_requested, cancel_requested_at=at)
        if self._start is None:
            return job
        started_at = datetime.fromisoformat(self._start.event.at)
        attempts = self._start.attempts
        return replace(job, state=JobState.RUNNING, started_at=started_at, attempts=attempts)

    async def run(self, worker: Worker) -> bool:
        """Run the job in a worker, which is given back; return whether it is queued again.

        Called in a task of its own: the ids of the job are bound in it from here on.
        """
        bind_ids(self.ids)
        if not await self._bring_artifacts(worker):
            # Only what the table has can be queued again.
            await self._is_confirmed.wait()
            return not self._is_discarded
        self.has_start_to_write = True
        start = asyncio.get_running_loop().create_task(self._write_start())
        start.add_done_callback(self._on_start)
        try:
            # What may run but once does not begin before that is written; the others save the time.
            if self.job.max_attempts == 1:
                await self._start_is_decided.wait()
            outcome = await self._run_task(worker)
            await self._start_is_decided.wait()
            self._start = await start
        except DatabaseTaken:
            return False
        except Exception:  # noqa: BLE001  (it is queued still)
            _log.exception("the start of %s could not be written", self.job.id)
            await asyncio.sleep(_RETRY_PERIOD)
            return True
        finally:
            start.cancel()
        if self._start is None:  # canceled while it was queued
            return False
        self._note_crash(outcome, self._start.attempts)
        outcome = await self._concluded(outcome)
        self._has_ended = True
        self.num_lost_hosts += isinstance(outcome, Lost) and outcome.has_begun
        pending, stage = await self._events.close(), self.latest("stage") or {}
        found = (self._start.attempts, self.num_lost_hosts, self._seconds, stage, pending)
        end = AttemptEnd(self.job, self._recorder, self._stop, *found)
        is_queued_again = await end.write(outcome)
        # Nothing was awaited since it was published: who is told of the end finds it here.
        self.ended = end.ended
        return is_queued_again

    def _note_crash(self, outcome: Outcome, attempts: int) -> None:
        stage = str((self.latest("stage") or {}).get("stage", ""))
        run = Run(self.job.queue, self.job.task, attempts, stage)
        note_crash(outcome, run, self._scheduler.observer)

    async def _concluded(self, outcome: Outcome) -> Outcome:
        """Return the outcome once what follows from it is done, or why that failed."""
        if not self._conclusion.concerns(self.job, self.latest):
            return outcome
        await self._events.flush()  # else a server that comes after would not know what was done
        has_succeeded = isinstance(outcome, Returned)
        try:
            await self._conclusion.conclude(self.job, self.latest, has_succeeded=has_succeeded)
        except WayproofError as fault:
            if has_succeeded:
                return Raised(fault)
            _log.warning("what follows from %s could not be done: %s", self.job.id, fault)
        except Exception as fault:  # noqa: BLE001  (no job may stay unfinished)
            _log.exception("what follows from %s could not be done", self.job.id)
            if has_succeeded:
                return Raised(InternalError(f"what follows failed: {type(fault).__name__}"))
        return outcome

    async def _bring_artifacts(self, worker: Worker) -> bool:
        """Return whether the worker has what the task reads; else it was given back."""
        try:
            await worker.bring(artifacts_of(self.job.task, self.job.payload))
        except Exception:  # noqa: BLE001  (the database is away, or the disk full: it is queued still)
            _log.exception("what %s reads could not be copied", self.job.id)
            self._scheduler.return_worker(self.job.queue, worker)
            await asyncio.sleep(_RETRY_PERIOD)
            return False
        return True

    async def _write_start(self) -> Transition | None:
        await self._is_confirmed.wait()
        if self._is_discarded or self._written_start is not None:
            return self._written_start
        store, identifier = self._recorder.store, self.job.id
        start = partial(store.start, identifier)
        return await self._recorder.apply(identifier, start, is_durable=False)

    def _on_start(self, start: asyncio.Task[Transition | None]) -> None:
        """Go on if the database took the start of a queued job, else end the run."""
        if not start.cancelled() and start.exception() is None:
            self._start = start.result()
        self._start_is_decided.set()
        if self._start is None or self._start.is_cancel_requested:
            self._terminate()

    async def _write_events(self, events: Sequence[PendingEvent]) -> None:
        """Record events of the run, once its start is."""
        await self._start_is_decided.wait()
        if self._start is not None:
            await self._recorder.append_events(self.job.id, events)

    @property
    def _may_begin(self) -> bool:
        if self._stop.is_cancel or self._stop.interruption:
            return False
        if not self._start_is_decided.is_set():
            return True
        return self._start is not None and not self._start.is_cancel_requested

    def _terminate(self) -> None:
        if self._worker is not None:
            self._worker.cancel(self.grace)

    async def _run_task(self, worker: Worker) -> Outcome:
        """Run the task and give the worker back before the end is written: others wait for it."""
        loop = asyncio.get_running_loop()
        began = loop.time()
        outcome: Outcome = Terminated(Canceled("canceled before it began"))
        job = self.job
        try:
            if self._may_begin:
                self._worker = worker
                payload = Encoded(encode(job.payload) if self._text is None else self._text)
                task = (job.task, payload, self._events, job.time_limit, self.controls)
                outcome = await run_traced(worker, Assignment(*task, ids=self.ids))
        except Exception as fault:  # noqa: BLE001  (no job may stay unfinished)
            _log.exception("the worker failed under %s", job.id)
            outcome = Raised(InternalError(f"the worker failed: {type(fault).__name__}"))
        finally:
            self._worker = None
            self._seconds = loop.time() - began
            self._scheduler.release(job.queue, worker, self._seconds)
        return outcome
