"""What clients want of jobs: that one runs, ends, or goes on in another way.

To write a job takes a few milliseconds of the disk's, and many a job takes no more. One that may
run twice does no harm if it ran for nothing, so it begins at once. Nothing of it is recorded before
the job itself, and what the table refuses leaves no trace.
"""

import asyncio
from collections.abc import Callable, Coroutine, Mapping, MutableMapping
from functools import partial
from typing import Any

from planning.errors import Canceled, IllegalTransition
from service.jobs.attempt import CONTROLS, Attempt
from service.jobs.errors import DatabaseTaken
from service.jobs.job import Job, JobSpec, JobSummary
from service.jobs.json_text import Encoded, encode
from service.jobs.recorder import JobRecorder
from service.jobs.scheduler import Scheduler
from service.jobs.states import JobState
from service.jobs.transitions import Draft, Transition, draft


class Intake:
    """Takes jobs in, from the event loop of a dispatcher."""

    def __init__(
        self,
        recording: JobRecorder,
        seat: Callable[[Job, Mapping[str, Any]], Attempt],
        unseat: Callable[[Attempt], None],
        within: float,
    ) -> None:
        """Write through `recording`.

        Args:
            recording: Of jobs.
            seat: Has a job run as soon as there is a slot.
            unseat: Takes that back.
            within: How long a job may take to be written; what takes longer is refused [s].
        """
        self._recording = recording
        self._seat = seat
        self._unseat = unseat
        self._within = within

    async def submit(self, spec: JobSpec) -> Job:
        """Queue a job, or return the one that its key names; it is durable when this returns.

        Raises:
            IdempotencyConflict: Its key was used for another request.
            DatabaseUnavailable: The database does not take it in time; it is not queued.
            DBAPIError: The database refuses it.
            TypeError: Its payload is not JSON-compatible.
        """
        drafted = draft(spec)
        # In time for what may run twice; a run of what may not waits for its start to be written.
        run = self._seat(drafted.job, {})
        try:
            # It is sent to its slot before the thread that writes takes part of the interpreter.
            await asyncio.sleep(0)
            job, is_new = await self._write(drafted)
        except BaseException:
            self._unseat(run)
            raise
        if is_new:
            run.confirm(job)
        else:
            self._unseat(run)
        return job

    async def _write(self, drafted: Draft) -> tuple[Job, bool]:
        # Not in this thread: while a locked database is waited for, others are to be stopped.
        enter = partial(self._recording.store.insert_draft, drafted)
        return await self._recording.write(enter, within=self._within)


# How long an answer waits for the database [s]; what is not written by then is written later.
_PROMPT = 0.5


class JobControl:
    """Cancels and controls the jobs of a dispatcher."""

    def __init__(
        self, runs: MutableMapping[str, Attempt], recording: JobRecorder, floor: Scheduler
    ) -> None:
        """Steer the runs that there are, by the ids of their jobs."""
        self._runs = runs
        self._recording = recording
        self._floor = floor

    async def cancel(self, identifier: str) -> JobSummary:
        """Ask for the end of a job, whatever its state, and return it; again does no harm.

        Raises:
            UnknownJob: There is none.
            DBAPIError: It neither waits nor runs, and the database does not answer.
        """
        run = self._runs.get(identifier)
        if run is None:
            job = await asyncio.to_thread(self._recording.store.summary, identifier)
            return job if job.state.is_final else await self._write_cancel(identifier)
        run.cancel()
        self._floor.queue(run.job.queue).remove(identifier)
        job = await self._recorded(identifier, "cancel", lambda: self._write_cancel(identifier))
        return job or run.snapshot()

    async def control(self, identifier: str, asked: Mapping[str, Any]) -> Job:
        """Ask something of a job that waits or runs, and return it.

        Raises:
            IllegalTransition: It has ended, or is to end.
        """
        run = self._runs.get(identifier)
        if run is None or not run.is_open:
            state = "canceling" if run is not None and run.is_cancel_requested else "at its end"
            message = f"job {identifier} is {state}: it cannot be steered any more"
            raise IllegalTransition(message, {"state": state, "event": "steer", "legal": []})
        run.control(asked)
        await self._recorded(identifier, CONTROLS, lambda: self._write_controls(run))
        return run.snapshot()

    async def _recorded[T](
        self, identifier: str, what: str, write: Callable[[], Coroutine[Any, Any, T]]
    ) -> T | None:
        """Return what a write gives, None if it has to be made later."""

        async def record() -> T | None:
            try:
                return await self._recording.write_until_done(identifier, what, write)
            except DatabaseTaken:
                return None

        work = asyncio.get_running_loop().create_task(record())
        self._floor.keep(work)
        done, _ = await asyncio.wait({work}, timeout=_PROMPT)
        return work.result() if done else None

    async def _write_cancel(self, identifier: str) -> Job:
        work = partial(self._cancel_in_store, identifier)
        job, moved = await self._recording.write(work)
        if moved is not None:
            self._recording.publish(identifier, [moved.event])
            run = self._runs.get(identifier)
            if run is not None and not run.has_begun:
                del self._runs[identifier]
                run.concluded.set()
        return job

    def _cancel_in_store(self, identifier: str) -> tuple[Job, Transition | None]:
        store = self._recording.store
        with store.transaction(is_durable=True):
            job = store.request_cancel(identifier)
            if job.state is not JobState.QUEUED:
                return job, None
            moved = store.cancel_queued(identifier, Canceled("canceled on request"))
            return store.request_cancel(identifier), moved

    async def _write_controls(self, run: Attempt) -> None:
        """Record all that is asked by now: a job that waits is told again after a restart."""
        told = [(CONTROLS, Encoded(encode(run.controls)))]
        await self._recording.append_events(run.job.id, told, may_wait=True)
