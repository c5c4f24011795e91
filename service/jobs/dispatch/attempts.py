"""Attempts: the jobs of a dispatcher that wait or run here, each until it has ended."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from service.jobs.dispatch.attempt import Attempt
from service.jobs.dispatch.recorder import JobRecorder
from service.jobs.dispatch.scheduler import Scheduler
from service.jobs.job import Job, JobSummary
from service.jobs.worker.assignment import Worker


class Attempts(dict[str, Attempt]):
    """Attempts by the ids of their jobs."""

    def __init__(
        self,
        recorder: JobRecorder,
        scheduler: Scheduler,
        on_end: Callable[[JobSummary], None] | None,
    ) -> None:
        """Have none yet.

        Args:
            recorder: Of what happens to jobs.
            scheduler: Where they run.
            on_end: Called with each job that ended here.
        """
        super().__init__()
        self._recorder = recorder
        self._scheduler = scheduler
        self._on_end = on_end

    def enqueue(self, job: Job, controls: Mapping[str, Any], order: int | None = None) -> None:
        """Run a queued job of the table when it has a worker."""
        self.schedule(job, controls, order).confirm(job)

    def schedule(self, job: Job, controls: Mapping[str, Any], order: int | None = None) -> Attempt:
        """Run a job when it has a worker; if its process dies it keeps its place in the queue."""
        place: list[int] = []
        attempt = Attempt(job, self._recorder, self._scheduler, controls)
        self[job.id] = attempt

        def use(worker: Worker) -> None:
            attempt.has_begun = True
            self._scheduler.spawn(self._run(attempt, worker, place))

        place.append(0 if order is None else order)
        place[0] = self._scheduler.request_worker(job, use, order)
        return attempt

    def unschedule(self, attempt: Attempt) -> None:
        """Have a job that the table does not have run no more."""
        attempt.discard()
        self.drop(attempt)

    def drop(self, attempt: Attempt) -> None:
        """Forget a job that does not run yet; one that runs is forgotten when it has ended."""
        self._scheduler.queue(attempt.job.queue).remove(attempt.job.id)
        if not attempt.has_begun:
            self.pop(attempt.job.id, None)
            attempt.concluded.set()

    def cancel(self, attempt: Attempt) -> None:
        """End a job on request; the table has that already, or is told by the caller."""
        attempt.cancel()
        self._scheduler.queue(attempt.job.queue).remove(attempt.job.id)

    def num_starting(self, queue: str, but: str) -> int:
        """Return how many jobs of a queue run, and wait by the table, but for one of an id."""
        every = [other for other in self.values() if other.job.queue == queue]
        return sum(other.is_starting and other.job.id != but for other in every)

    def interrupt(self, reason: str) -> None:
        """Begin nothing more, and end what runs."""
        self._scheduler.pause()
        for attempt in self.values():
            if attempt.has_begun:
                attempt.interrupt(reason)

    async def _run(self, attempt: Attempt, worker: Worker, place: list[int]) -> None:
        is_queued_again = False
        try:
            is_queued_again = await attempt.run(worker)
        finally:
            self.pop(attempt.job.id, None)
            attempt.concluded.set()
        if attempt.ended is not None and self._on_end is not None:
            self._on_end(attempt.ended.summary)
        if is_queued_again:
            job = replace(attempt.job, is_cancel_requested=attempt.is_cancel_requested)
            self.enqueue(job, attempt.controls, place[0])
