"""JobService: durable jobs for coroutines of one event loop, by way of store and dispatcher."""

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any, Literal, Self

from anyio import to_thread

from service.errors import NotReady, ServerStopping, UnknownResource
from service.jobs.dispatch.dispatcher import Dispatcher
from service.jobs.dispatch.release import JobRelease
from service.jobs.dispatch.scheduling.scheduler import QueueLoad
from service.jobs.errors import UnknownJob
from service.jobs.job import (
    BatchMember,
    Job,
    JobSpec,
    JobSummary,
    JobText,
    LoggedEvent,
)
from service.jobs.reader import JobReader
from service.jobs.states import JobState
from service.jobs.store.deletion import delete_on_request
from service.jobs.store.job_store import JobStore
from service.jobs.task_calls import CallTerms, TaskCalls


class JobService(JobReader, TaskCalls):
    """Submits, reads, follows, controls and cancels jobs, and calls short tasks.

    Attributes:
        on_delete: Called after jobs were deleted on request.
        client: Whom it works for: clients take turns.
    """

    def __init__(
        self,
        store: JobStore,
        dispatcher: Dispatcher,
        *,
        prefixes: Mapping[str, str],
        queues: Sequence[str],
        terms: CallTerms | None = None,
    ) -> None:
        """Put the parts together.

        Args:
            store: The record of jobs.
            dispatcher: Runs them already.
            prefixes: Of the ids of each queue's jobs.
            queues: The names of all queues, in the order in which they are counted.
            terms: On which short tasks are called.
        """
        JobReader.__init__(self, store, prefixes=prefixes, queues=queues)
        TaskCalls.__init__(self, dispatcher, terms or CallTerms())
        self.on_delete: Callable[[], None] | None = None

    def for_client(self, client: str) -> Self:
        """Return the same service for a client: what it requests is that client's."""
        # `copy` takes ten times as long, of every request.
        own = object.__new__(type(self))
        own.__dict__.update(self.__dict__, client=client)
        return own

    async def submit(self, spec: JobSpec) -> Job:
        """Queue a job; it is durable when this returns.

        Raises:
            QueueFull: Its queue has as many waiting jobs as it may.
            IdempotencyConflict: Its key was used for another request.
        """
        return await self._dispatcher.submit(replace(spec, client=self.client))

    async def submit_all(self, specs: Sequence[JobSpec]) -> list[Job]:
        """Queue jobs of one queue, all of them or none; they are durable when this returns.

        Where the key of the first one was used before, the job that it names is returned alone.

        Raises:
            QueueFull: Its queue would have more waiting jobs than it may.
            IdempotencyConflict: The key was used for another request.
        """
        own = [replace(spec, client=self.client) for spec in specs]
        return await self._dispatcher.submit_all(own)

    @property
    def waiting(self) -> JobRelease:
        """What releases jobs that wait for their robots; of a server that leads."""
        return self._dispatcher.waiting

    async def open_job(self, queue: str, identifier: str) -> JobSummary:
        """Return a job that waits or runs here as memory has it, any other one as lists have it.

        Raises:
            UnknownResource: The queue has none of that id.
        """
        run = self._dispatcher.attempt_of(identifier)
        if run is not None and run.job.queue == queue:
            return run.snapshot()
        return await self._read(queue, identifier, self._store.summary)

    async def wait(self, job: Job, seconds: float) -> JobText:
        """Return a job when it has ended, or as it is after some seconds."""
        if seconds > 0:
            return await self._dispatcher.wait_text(job.id, seconds)
        return await self.text_of(job)

    async def wait_for_all(self, jobs: Sequence[str], seconds: float) -> bool:
        """Wait until jobs have ended, at most some seconds, and return whether all have."""
        clock = asyncio.get_running_loop().time
        end = clock() + seconds
        for identifier in jobs:
            left = max(0.0, end - clock())
            found = await self._dispatcher.wait_text(identifier, left) if left else None
            if found is None or not found.summary.state.is_final:
                return False
        return True

    async def text_of(self, job: JobSummary) -> JobText:
        """Return a job with its result, if it has one."""
        has_one = job.state is JobState.SUCCEEDED
        return await self.job_text(job.queue, job.id) if has_one else JobText(job, None)

    async def cancel(self, job: JobSummary | BatchMember) -> JobSummary:
        """End a job, whatever its state; no database is waited for."""
        return await self._dispatcher.cancel(job.id)

    async def control(self, job: JobSummary, controls: dict[str, Any]) -> Job:
        """Set controls of a job that waits or runs; no database is waited for.

        Raises:
            IllegalTransition: It has ended, or is to end.
        """
        return await self._dispatcher.control(job.id, controls)

    async def delete(self, *found: JobSummary | BatchMember) -> None:
        """Delete jobs that have ended, all of them or none, with all that was recorded of them.

        Raises:
            IllegalTransition: One has not ended.
            JobInUse: A job that has not ended names it.
            UnknownResource: Another request was quicker.
        """
        try:
            await to_thread.run_sync(delete_on_request, self._store, *(job.id for job in found))
        except UnknownJob as fault:
            raise UnknownResource.of("job", fault.evidence["id"]) from fault
        if self.on_delete is not None:
            self.on_delete()

    def unrecorded(self, job: JobSummary) -> list[str]:
        """Return what has happened to a job and is not in the database yet."""
        run = None if job.state.is_final else self._dispatcher.attempt_of(job.id)
        return [] if run is None else run.unrecorded

    def with_cancel(self, job: JobSummary) -> JobSummary:
        """Return a job as the database has it, with a cancel that it does not hold yet."""
        run = None if job.state.is_final else self._dispatcher.attempt_of(job.id)
        if run is None or not run.is_cancel_requested:
            return job
        return replace(job, is_cancel_requested=True, cancel_requested_at=run.cancel_requested_at)

    async def drain(self) -> None:
        """Take and begin no more jobs, and wait for those that run; see `Dispatcher.drain`."""
        await self._dispatcher.drain()

    def begin_to_stop(self) -> None:
        """Begin nothing more, and tell what runs to end, before `Dispatcher.stop` waits for it."""
        self._dispatcher.begin_to_stop()

    async def events(self, job: JobSummary | BatchMember, after: int) -> AsyncIterator[LoggedEvent]:
        """Yield a job's events with numbers above `after`, until it has ended."""
        async for event in self.events_of(job.id, after):
            yield event

    async def events_of(self, identifier: str, after: int) -> AsyncIterator[LoggedEvent]:
        """Yield events as `events` does, of the job of an id.

        Raises:
            UnknownJob: There is none.
        """
        async for event in self._dispatcher.subscribe(identifier, after):
            yield event

    def watch(self, name: str) -> AbstractContextManager[Callable[[], asyncio.Event]]:
        """Watch what has a name: what is lent returns the event of its next change."""
        return self._dispatcher.watch(name)

    def wake(self, name: str) -> None:
        """Tell those who watch a name here that it has changed."""
        self._dispatcher.wake(name)

    @property
    def is_stopping(self) -> bool:
        """Whether the server ends: what is watched is told no more."""
        return self._dispatcher.is_stopping

    async def latest_event(self, job: JobSummary, event_type: str) -> dict[str, Any] | None:
        """Return the data of the newest event of a type, recorded or not, if there is one."""
        run = self._dispatcher.attempt_of(job.id)
        if run is not None:
            return run.latest(event_type)
        event = await to_thread.run_sync(self._store.last_event, job.id, event_type)
        return None if event is None else event.data

    def check_ready(self) -> None:
        """Go on only if workers of every queue are warm.

        Raises:
            NotReady: They are not, yet or any more.
            ServerStopping: The server is to end.
        """
        if self._dispatcher.is_draining:
            raise ServerStopping("the server is about to end: what runs may end first")
        faults = self._dispatcher.faults()
        if faults:
            named = "; ".join(f"{queue}: {fault}" for queue, fault in faults.items())
            raise NotReady(f"not ready: {named}"[:500], {"faults": faults, "retry_after": 1})

    @property
    def role(self) -> Literal["leader", "follower"]:
        """What this server is among those of the database: the leader runs the jobs."""
        return self._dispatcher.role

    def loads(self) -> dict[str, QueueLoad]:
        """Return what waits and what works, by queue."""
        return self._dispatcher.loads()
