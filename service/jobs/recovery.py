"""Recovery: what an earlier server left is queued again, or ended with the reason."""

import asyncio
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from planning.errors import Canceled
from service.jobs.errors import InternalError, ServerRestarted
from service.jobs.floor import Floor
from service.jobs.job_run import CONTROLS
from service.jobs.ownership import Ownership
from service.jobs.recording import Recording
from service.jobs.records import Job
from service.jobs.states import JobState


class Recovery:
    """Takes up the jobs that are queued or running in the table when a server starts."""

    def __init__(
        self,
        recording: Recording,
        ownership: Ownership,
        floor: Floor,
        enqueue: Callable[[Job, Mapping[str, Any]], None],
    ) -> None:
        """Prepare.

        Args:
            recording: Of jobs.
            ownership: Of the database, just taken.
            floor: Where jobs run.
            enqueue: Queues a job with what was asked of it.
        """
        self._store = recording.store
        self._recording = recording
        self._floor = floor
        self._enqueue = enqueue
        self._may_run_still = ownership.may_be_lost and ownership.was_left

    def run(self, takeover: float) -> None:
        """Take up all jobs.

        Args:
            takeover: How long an owner that lost the database without ending may still run
                something [s]; only after that it is taken up.
        """
        for job in self._store.unfinished():
            if self._may_run_still and job.state is JobState.RUNNING:
                self._floor.spawn(self._recover_later(job.id, takeover))
            elif self._is_to_run(job):
                self._enqueue(job, self._controls(job.id))

    async def _recover_later(self, identifier: str, seconds: float) -> None:
        await asyncio.sleep(seconds)

        def recover() -> Job | None:
            job = self._store.get(identifier)
            return job if self._is_to_run(job) else None

        write = partial(self._recording.write, recover)
        job = await self._recording.insist(identifier, "recovery", write)
        if job is not None:
            self._enqueue(job, {})

    def _is_to_run(self, job: Job) -> bool:
        """Return whether a job is to run; else write how it ended."""
        if job.is_cancel_requested:
            self._store.cancel(job.id, Canceled("canceled on request"))
        elif job.lane not in self._floor:
            self._store.fail(job.id, InternalError(f"this server has no lane {job.lane!r}"))
        elif job.state is JobState.QUEUED:
            return True
        elif job.attempts < job.max_attempts:
            self._store.requeue(job.id, "the server ended while this ran")
            return True
        else:
            message = "the server ended while this ran"
            self._store.fail(job.id, ServerRestarted(message, {"attempts": job.attempts}))
        return False

    def _controls(self, identifier: str) -> dict[str, Any]:
        """Return what was asked of a job before the earlier server ended."""
        asked = self._store.last_event(identifier, CONTROLS)
        return {} if asked is None else asked.data
