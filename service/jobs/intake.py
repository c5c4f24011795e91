"""Intake: new jobs, which may run while they are written, and are told of once they are durable.

To write a job takes a few milliseconds of the disk's, and many a job takes no more. One that may
run twice does no harm if it ran for nothing, so it begins at once. Nothing of it is recorded before
the job itself, and what the table refuses leaves no trace.
"""

import asyncio
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from service.jobs.attempt import Attempt
from service.jobs.enrolling import Draft, draft
from service.jobs.recorder import JobRecorder
from service.jobs.tables import Job, JobSpec


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
