"""Recovery: jobs of the table are taken up; what ran is queued again, or ended with the reason."""

import asyncio
import logging
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from planning.errors import Canceled, WayproofError
from service.jobs.dispatch.conclusion import Conclusion, LastEvent
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.dispatch.recorder import JobRecorder
from service.jobs.dispatch.scheduling.scheduler import Scheduler
from service.jobs.errors import InternalError, ServerRestarted
from service.jobs.job import CONTROLS, Job
from service.jobs.states import JobState
from service.jobs.store.sql.database import ask
from service.jobs.store.transitions import Transition

# Type of the events that say how far a task is.
_STATUS = "status"
_log = logging.getLogger(__name__)


class Recovery:
    """Takes up the jobs that are queued or running in the table when a server begins to lead."""

    def __init__(
        self,
        recorder: JobRecorder,
        lock: DispatcherLock,
        scheduler: Scheduler,
        enqueue: Callable[[Job, Mapping[str, Any]], None],
        conclusion: Conclusion,
    ) -> None:
        """Prepare.

        Args:
            recorder: Of jobs.
            lock: On the database, just taken.
            scheduler: Where jobs run.
            enqueue: Queues a job with its controls.
            conclusion: What is done before the end of a job is recorded.
        """
        self._store = recorder.store
        self._recorder = recorder
        self._scheduler = scheduler
        self._enqueue = enqueue
        self._conclusion = conclusion
        self._lock = lock

    async def run(self, takeover: float) -> None:
        """Take up all jobs, the lock just taken; none begins before the queues know all of them.

        Args:
            takeover: How long an owner that lost the database without ending may still run
                something [s]; only after that it is taken up.
        """
        may_still_run = self._lock.may_be_lost and self._lock.was_left
        with self._scheduler.holding():
            for job in await asyncio.to_thread(self._store.unfinished):
                if may_still_run and job.state is JobState.RUNNING:
                    self._scheduler.spawn(self._recover_later(job.id, takeover))
                else:
                    await self.take_up(job)

    async def take_up(self, job: Job) -> None:
        """Queue a job of the table here, or end it; raises as `JobRecorder.write`."""
        if await self._is_to_be_concluded(job):
            self._scheduler.spawn(self._conclude(job.id))
            return
        transition: Transition | None = None
        if job.state is not JobState.QUEUED or self._is_at_its_end(job):
            transition = await self._recorder.write(partial(self._settle, job))
        if transition is not None:
            self._recorder.publish(job.id, [transition.event])
        if transition is None or not transition.event.is_last:
            # A job of which nothing but that it is queued has been recorded has none.
            has_controls = job.num_events > 1
            controls = await ask(self._controls, job.id) if has_controls else {}
            self._enqueue(job, controls)

    async def _recover_later(self, identifier: str, seconds: float) -> None:
        await asyncio.sleep(seconds)
        job = await ask(self._store.get, identifier)
        if await self._is_to_be_concluded(job):
            await self._conclude(identifier)
        else:
            await self._settle_later(identifier)

    async def _is_to_be_concluded(self, job: Job) -> bool:
        """Return whether a job that was left has to be looked into before it is ended."""
        is_last = job.state is JobState.RUNNING and job.attempts >= job.max_attempts
        if not is_last or job.queue not in self._scheduler:
            return False
        return self._conclusion.concerns(job, await self._last_events(job.id))

    async def _last_events(self, identifier: str) -> LastEvent:
        event = await ask(self._store.last_event, identifier, _STATUS)
        found = {} if event is None else {_STATUS: event.data}
        return found.get

    async def _conclude(self, identifier: str) -> None:
        """End a job that was left, with the result that its task had, or with why it has none."""
        job = await ask(self._store.get, identifier)
        last = await self._last_events(identifier)
        end: Callable[[], Transition | None] = partial(self._settle, job)
        try:
            result = await self._conclusion.recovered(job, last)
            if result is not None:
                end = partial(self._store.succeed, identifier, result)
        except WayproofError as fault:
            end = partial(self._store.fail, identifier, fault)
        except Exception:  # noqa: BLE001  (no job may stay unfinished)
            _log.exception("what follows from %s could not be done", identifier)
        write = partial(self._recorder.write, end)
        transition = await self._recorder.write_until_done(identifier, "recovery", write)
        if transition is not None:
            self._recorder.publish(identifier, [transition.event])

    async def _settle_later(self, identifier: str) -> None:
        def recover() -> tuple[Job, Transition | None]:
            job = self._store.get(identifier)
            return job, self._settle(job)

        write = partial(self._recorder.write, recover)
        job, transition = await self._recorder.write_until_done(identifier, "recovery", write)
        if transition is not None:
            self._recorder.publish(identifier, [transition.event])
            if not transition.event.is_last:
                self._enqueue(job, await ask(self._controls, identifier))

    def _is_at_its_end(self, job: Job) -> bool:
        return job.is_cancel_requested or job.queue not in self._scheduler

    def _settle(self, job: Job) -> Transition | None:
        """Write what becomes of a job that was left; None if it only has to run."""
        if job.is_cancel_requested:
            return self._store.cancel(job.id, Canceled("canceled on request"))
        if job.queue not in self._scheduler:
            message = f"this server has no queue {job.queue!r}"
            return self._store.fail(job.id, InternalError(message))
        if job.state is JobState.QUEUED:
            return None
        if job.attempts < job.max_attempts:
            return self._store.requeue(job.id, "the server ended while this ran")
        error = ServerRestarted("the server ended while this ran", {"attempts": job.attempts})
        return self._store.fail(job.id, error)

    def _controls(self, identifier: str) -> dict[str, Any]:
        """Return the controls of a job that were set before the earlier server ended."""
        event = self._store.last_event(identifier, CONTROLS)
        return {} if event is None else event.data
