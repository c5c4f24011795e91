"""Attempts: the jobs of a dispatcher that wait or run here, each until it has ended."""

import asyncio
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import Any

from service.jobs.dispatch.attempt import Attempt
from service.jobs.dispatch.conclusion import Conclusion
from service.jobs.dispatch.observer import Observer
from service.jobs.dispatch.recorder import JobRecorder
from service.jobs.dispatch.scheduling.scheduler import Scheduler
from service.jobs.dispatch.scheduling.waiting import Place, QueueEntry
from service.jobs.job import Job
from service.jobs.worker.assignment import Worker


class Attempts(dict[str, Attempt]):
    """Attempts by the ids of their jobs."""

    def __init__(
        self,
        recorder: JobRecorder,
        scheduler: Scheduler,
        observer: Observer,
        conclusion: Callable[[], Conclusion],
    ) -> None:
        """Have none yet.

        Args:
            recorder: Of what happens to jobs.
            scheduler: Where they run.
            observer: Hears of each job that ended here.
            conclusion: Returns what is done before the end of a job is recorded.
        """
        super().__init__()
        self._recorder = recorder
        self._scheduler = scheduler
        self._observer = observer
        self._conclusion = conclusion

    def enqueue(self, job: Job, controls: Mapping[str, Any], place: Place | None = None) -> None:
        """Run a queued job of the table when it has a worker."""
        self.schedule(job, controls, place).confirm(job)

    def schedule(
        self,
        job: Job,
        controls: Mapping[str, Any],
        place: Place | None = None,
        text: str | None = None,
    ) -> Attempt:
        """Run a job when it has a worker; if its process dies it keeps its place in the queue.

        Args:
            job: To run.
            controls: That are set.
            place: In the queue; None for the last one.
            text: Its payload as JSON, if that is known.
        """
        attempt = Attempt(job, self._recorder, self._scheduler, controls, self._conclusion(), text)
        self[job.id] = attempt
        own = place or self._scheduler.next_place(job.queue)

        def use(worker: Worker) -> None:
            attempt.has_begun = True
            self._scheduler.begin(self._run(attempt, worker, own))

        terms = (job.world_digest, job.priority, job.client)
        self._scheduler.request(job.queue, QueueEntry(job.id, own, use, *terms))
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

    def num_starting(self, queue: str, but: Collection[str]) -> int:
        """Return how many jobs of a queue run, and wait by the table, but for those of some ids."""
        every = [other for other in self.values() if other.job.queue == queue]
        return sum(other.is_starting and other.job.id not in but for other in every)

    async def _run(self, attempt: Attempt, worker: Worker, place: Place) -> None:
        is_queued_again = False
        try:
            is_queued_again = await attempt.run(worker)
        finally:
            self.pop(attempt.job.id, None)
            attempt.concluded.set()
        if attempt.ended is not None:
            # Who waits for the end is told first.
            loop = asyncio.get_running_loop()
            loop.call_soon(self._observer.note_end, attempt.ended.summary)
        if is_queued_again:
            job = replace(
                attempt.job,
                is_cancel_requested=attempt.is_cancel_requested,
                cancel_requested_at=attempt.cancel_requested_at,
            )
            self.enqueue(job, attempt.controls, place)
            self[job.id].num_lost_hosts = attempt.num_lost_hosts
