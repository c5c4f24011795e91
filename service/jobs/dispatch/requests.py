"""What clients request of jobs: that one runs, that it ends, or that it goes on in another way."""

import asyncio
from collections.abc import Callable, Coroutine, Mapping, MutableMapping, Sequence
from datetime import datetime
from functools import partial
from typing import Any

from planning.errors import Canceled, IllegalTransition
from service.jobs.dispatch.attempt import CONTROLS, Attempt
from service.jobs.dispatch.recorder import JobRecorder
from service.jobs.dispatch.scheduler import Scheduler
from service.jobs.errors import DatabaseTaken
from service.jobs.job import Job, JobSpec, JobSummary, JobText
from service.jobs.json_text import Encoded, encode
from service.jobs.states import JobState
from service.jobs.store.transitions import Transition, draft

# How long an answer waits for the database [s]; what is not written by then is written later.
_PROMPT = 0.5


class JobSubmission:
    """Submits jobs, which may run while they are written, and are answered once they are durable.

    To write a job takes a few milliseconds of the disk's, and many a job takes no more. One that
    may run twice does no harm if it ran for nothing, so it begins at once. Nothing of it is
    recorded before the job itself, and what the table refuses leaves no trace.
    """

    def __init__(
        self,
        recorder: JobRecorder,
        schedule: Callable[[Job, Mapping[str, Any]], Attempt],
        unschedule: Callable[[Attempt], None],
        within: float,
    ) -> None:
        """Put the parts together.

        Args:
            recorder: Writes jobs.
            schedule: Has a job run as soon as there is a worker.
            unschedule: Takes that back.
            within: How long a job may take to be written; what takes longer is refused [s].
        """
        self._recorder = recorder
        self._schedule = schedule
        self._unschedule = unschedule
        self._within = within

    async def submit(self, spec: JobSpec) -> Job:
        """Queue a job, or return the one that its key names; see `submit_all`."""
        [job] = await self.submit_all([spec])
        return job

    async def submit_all(self, specs: Sequence[JobSpec]) -> list[Job]:
        """Queue jobs, all of them or none; they are durable when this returns.

        Where the key of the first one was used before, the job that it names is returned alone.

        Raises:
            IdempotencyConflict: Its key was used for another request.
            DatabaseUnavailable: The database does not take it in time; it is not queued.
            DBAPIError: The database refuses it.
            TypeError: Its payload is not JSON-compatible.
        """
        drafts = [draft(spec) for spec in specs]
        # In time for what may run twice; a run of what may not waits for its start to be written.
        attempts = [self._schedule(drafted.job, {}) for drafted in drafts]
        try:
            # It is sent to its worker before the thread that writes takes part of the interpreter.
            await asyncio.sleep(0)
            # Not in this thread: while a locked database is waited for, others are to be stopped.
            insert = partial(self._recorder.store.insert_drafts, drafts)
            jobs, are_new = await self._recorder.write(insert, within=self._within)
        except BaseException:
            self._take_back(attempts)
            raise
        if are_new:
            for attempt, job in zip(attempts, jobs, strict=True):
                attempt.confirm(job)
        else:
            self._take_back(attempts)
        return jobs

    def _take_back(self, attempts: Sequence[Attempt]) -> None:
        for attempt in reversed(attempts):  # what waits does not begin because of what ends
            self._unschedule(attempt)


class JobControl:
    """Cancels and controls the jobs of a dispatcher; an attempt hears of it before the database."""

    def __init__(
        self,
        attempts: MutableMapping[str, Attempt],
        recorder: JobRecorder,
        scheduler: Scheduler,
    ) -> None:
        """Control the attempts that there are, by the ids of their jobs."""
        self._attempts = attempts
        self._recorder = recorder
        self._scheduler = scheduler

    async def cancel(self, identifier: str) -> JobSummary:
        """End a job, whatever its state, and return it; again does no harm.

        A queued job ends at once. A running one is told, and its process ended if need be; wait
        for it. One that returns its result all the same has succeeded. No database is waited for.

        Raises:
            UnknownJob: There is none.
            DBAPIError: It neither waits nor runs, and the database does not answer.
        """
        attempt = self._attempts.get(identifier)
        if attempt is None:
            job = await asyncio.to_thread(self._recorder.store.summary, identifier)
            return job if job.state.is_final else await self._write_cancel(identifier, None)
        attempt.cancel()
        at = attempt.cancel_requested_at
        self._scheduler.queue(attempt.job.queue).remove(identifier)
        job = await self._recorded(identifier, "cancel", lambda: self._write_cancel(identifier, at))
        return job or attempt.snapshot()

    async def control(self, identifier: str, controls: Mapping[str, Any]) -> Job:
        """Set controls of a job that waits or runs, and return it.

        Raises:
            IllegalTransition: It has ended, or is to end.
        """
        attempt = self._attempts.get(identifier)
        if attempt is None or not attempt.is_open:
            is_ending = attempt is not None and attempt.is_cancel_requested
            state = "canceling" if is_ending else "at its end"
            message = f"job {identifier} is {state}: it cannot be steered any more"
            raise IllegalTransition(message, {"state": state, "event": "steer", "legal": []})
        attempt.control(controls)
        await self._recorded(identifier, CONTROLS, lambda: self._write_controls(attempt))
        return attempt.snapshot()

    async def _recorded[T](
        self, identifier: str, what: str, write: Callable[[], Coroutine[Any, Any, T]]
    ) -> T | None:
        """Return what a write gives, None if it has to be made later."""

        async def record() -> T | None:
            try:
                return await self._recorder.write_until_done(identifier, what, write)
            except DatabaseTaken:
                return None

        work = asyncio.get_running_loop().create_task(record())
        self._scheduler.keep(work)
        done, _ = await asyncio.wait({work}, timeout=_PROMPT)
        return work.result() if done else None

    async def _write_cancel(self, identifier: str, at: datetime | None) -> Job:
        job, ended = await self._recorder.write(partial(self._cancel_in_store, identifier, at))
        if ended is not None:
            self._recorder.publish(identifier, [ended.event])
            attempt = self._attempts.get(identifier)
            if attempt is not None:
                # One that had a worker already concludes later; who waits is answered now.
                attempt.ended = JobText(job, None)
                if not attempt.has_begun:
                    del self._attempts[identifier]
                    attempt.concluded.set()
        return job

    def _cancel_in_store(
        self, identifier: str, at: datetime | None
    ) -> tuple[Job, Transition | None]:
        store = self._recorder.store
        with store.transaction(is_durable=True):
            job = store.request_cancel(identifier, at)
            if job.state is not JobState.QUEUED:
                return job, None
            ended = store.cancel_queued(identifier, Canceled("canceled on request"))
            return store.request_cancel(identifier), ended

    async def _write_controls(self, attempt: Attempt) -> None:
        """Record all controls by now: a job that waits is told again after a restart."""
        controls = [(CONTROLS, Encoded(encode(attempt.controls)))]
        await self._recorder.append_events(attempt.job.id, controls, may_wait=True)
