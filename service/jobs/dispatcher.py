"""Dispatcher: takes jobs from the table to the slots and their ends back to the table."""

import asyncio
import logging
from collections.abc import AsyncGenerator, Callable, Mapping
from contextlib import aclosing
from dataclasses import replace
from typing import Any

from service.jobs.attempt import Attempt
from service.jobs.calls import Answer, Calls, Question
from service.jobs.event_bus import EventBatch, EventBus
from service.jobs.intake import Intake
from service.jobs.leader import DispatcherLock
from service.jobs.ownership_watch import DatabaseTimeouts, LockWatch
from service.jobs.queue import JobQueue
from service.jobs.recorder import JobRecorder
from service.jobs.recovery import Recovery
from service.jobs.scheduler import QueueLoad, Scheduler
from service.jobs.steering import JobControl
from service.jobs.store import JobStore
from service.jobs.tables import Job, JobSpec, JobSummary, JobText, LoggedEvent
from service.jobs.waiting import END_OF_STREAM, JobWaits
from service.jobs.worker.process_worker import Worker

# To record the ends of what ran when the server stops [s].
_WRITING = 5.0
_log = logging.getLogger(__name__)


def _nothing() -> None:
    pass


class Dispatcher:
    """Runs every job of one database, from one event loop."""

    def __init__(
        self,
        store: JobStore,
        lock: DispatcherLock,
        queues: Mapping[str, JobQueue],
        *,
        on_taken: Callable[[], None] = _nothing,
        on_end: Callable[[JobSummary], None] | None = None,
        timeouts: DatabaseTimeouts | None = None,
    ) -> None:
        """Put the parts together; `start` begins.

        Args:
            store: The record of jobs.
            lock: On the database.
            queues: Where jobs run, by name.
            on_taken: Called once when another server has taken the database over.
            on_end: Called with each job that ended here.
            timeouts: How long a database may be out of reach.
        """
        self.is_taken = False
        self._on_taken = on_taken
        self._on_end = on_end
        self._timeouts = timeouts or DatabaseTimeouts()
        self._store = store
        self._lock = lock
        self._scheduler = Scheduler(queues)
        self._bus: EventBus[LoggedEvent] = EventBus(self._read_events)
        self._attempts: dict[str, Attempt] = {}
        self._calls = Calls(self._scheduler)
        self._waiting = JobWaits(self._attempts, self._bus, store)
        self._recorder: JobRecorder
        self._steering: JobControl
        self._intake: Intake

    async def start(self, warm_up: str | None = None) -> None:
        """Take the database, recover what an earlier server left, and begin to warm the slots.

        Args:
            warm_up: A task that every process runs first.

        Raises:
            DatabaseInUse: Another dispatcher has the database.
        """
        await asyncio.to_thread(self._lock.take)
        try:
            self._store.set_epoch(self._lock.epoch)
            await asyncio.to_thread(self._store.open)
            self._recorder = JobRecorder(self._store, self._bus, self.give_up)
            self._steering = JobControl(self._attempts, self._recorder, self._scheduler)
            within = self._timeouts.record
            self._intake = Intake(self._recorder, self._schedule, self._unschedule, within)
            await self._scheduler.open(warm_up)
            recovery = Recovery(self._recorder, self._lock, self._scheduler, self._enqueue)
            await recovery.run(self._timeouts.takeover)
        except BaseException:
            await asyncio.to_thread(self._lock.release)
            raise
        if self._lock.may_be_lost:
            self._scheduler.spawn(LockWatch(self._lock, self, self._timeouts).run())

    async def stop(self) -> None:
        """Bring what runs to its end, end every slot and release the database.

        What was interrupted is queued again if it may run again; that does not count as an attempt.
        """
        self.begin_to_stop()
        running = [run for run in self._attempts.values() if run.has_begun]
        longest = max((run.grace for run in running), default=0.0) + _WRITING
        waits = [asyncio.ensure_future(run.concluded.wait()) for run in running]
        if waits:
            _, late = await asyncio.wait(waits, timeout=longest)
            for wait in late:
                wait.cancel()
            if late:
                _log.error("the ends of %d jobs could not be recorded", len(late))
        self._bus.close()
        await self._scheduler.close()
        await self._recorder.close()
        await asyncio.to_thread(self._lock.release)

    def begin_to_stop(self) -> None:
        """Begin nothing more, and tell what runs to end: a robot comes to rest on its path.

        Who waits for a job is answered at once: what waited would be cut off.
        """
        self._waiting.end()
        self._end_runs("the server stopped")

    def suspend(self) -> None:
        """Begin nothing, and end what runs: the database may be another's by now."""
        self._end_runs("the database was out of reach")

    def resume(self) -> None:
        """Work again after `suspend`."""
        self._scheduler.resume()

    def give_up(self) -> None:
        """End what runs, and do nothing more: another has the database."""
        if not self.is_taken:
            self.is_taken = True
            _log.critical("another server has taken the database over: this one gives up")
            self._end_runs("another server took the database over")
            self._on_taken()

    def attempt_of(self, identifier: str) -> Attempt | None:
        """Return what memory has of a job that waits or runs here, None if it does not."""
        return self._attempts.get(identifier)

    def loads(self) -> dict[str, QueueLoad]:
        """Return what waits and what works, by queue."""
        return self._scheduler.loads()

    def faults(self) -> dict[str, str]:
        """Return why lanes cannot begin a job well, by name; empty if all can."""
        return self._scheduler.faults()

    async def submit(self, spec: JobSpec) -> Job:
        """Queue a job; it is durable when this returns.

        Raises:
            QueueFull: Its lane has as many waiting jobs as it may.
            IdempotencyConflict: Its key was used for another request.
            DatabaseUnavailable: The database does not take it in time; it is not queued.
            DBAPIError: The database refuses it.
        """
        if spec.key:
            asked = (spec.queue, spec.key, spec.request_digest)
            known = await asyncio.to_thread(self._store.find_by_key, *asked)
            if known:
                return known
        self._scheduler.check_room(spec.queue)
        return await self._intake.submit(spec)

    async def cancel(self, identifier: str) -> JobSummary:
        """Ask for the end of a job, whatever its state, and return it; again does no harm.

        A queued job ends at once. A running one is asked, and its process ended if need be; wait
        for it. One that returns its result all the same has succeeded. No database is waited for.

        Raises:
            UnknownJob: There is none.
        """
        return await self._steering.cancel(identifier)

    async def control(self, identifier: str, asked: Mapping[str, Any]) -> Job:
        """Ask something of a job that waits or runs, and return it.

        Raises:
            IllegalTransition: It has ended, or is to end.
        """
        return await self._steering.control(identifier, asked)

    async def wait(self, identifier: str, seconds: float) -> Job:
        """Return a job when it has ended, or as it is after so many seconds, or when we end.

        Raises:
            UnknownJob: There is none.
        """
        return await self._waiting.whole(identifier, seconds)

    async def wait_text(self, identifier: str, seconds: float) -> JobText:
        """Return a job as `wait` does, but for its result, which stays text.

        Raises:
            UnknownJob: There is none.
        """
        return await self._waiting.text(identifier, seconds)

    async def subscribe(self, identifier: str, after: int = 0) -> AsyncGenerator[LoggedEvent]:
        """Yield a job's events with numbers above `after`, each once, until it has ended.

        Raises:
            UnknownJob: There is none.
        """
        async with aclosing(self._bus.follow(identifier, min(after, END_OF_STREAM))) as events:
            async for event in events:
                yield event

    async def call(self, question: Question) -> Answer:
        """Run a short task that needs no record, and return what it returns; see `Calls.ask`."""
        return await self._calls.ask(question)

    def _enqueue(self, job: Job, controls: Mapping[str, Any], order: int | None = None) -> None:
        """Run a queued job of the table when it has a slot."""
        self._schedule(job, controls, order).confirm(job)

    def _schedule(self, job: Job, controls: Mapping[str, Any], order: int | None = None) -> Attempt:
        """Run a job when it has a slot; if its process dies it keeps its place."""
        place: list[int] = []
        run = self._attempts[job.id] = Attempt(job, self._recorder, self._scheduler, controls)

        def use(slot: Worker) -> None:
            run.has_begun = True
            self._scheduler.spawn(self._run(run, slot, place))

        place.append(0 if order is None else order)
        place[0] = self._scheduler.request_worker(
            job.queue,
            job.id,
            use,
            world_digest=job.world_digest,
            priority=job.priority,
            order=order,
        )
        return run

    def _unschedule(self, run: Attempt) -> None:
        """Have a job that the table does not have run no more."""
        run.discard()
        self._scheduler.queue(run.job.queue).remove(run.job.id)
        if not run.has_begun:
            self._attempts.pop(run.job.id, None)
            run.concluded.set()

    async def _run(self, run: Attempt, slot: Worker, place: list[int]) -> None:
        is_queued_again = False
        try:
            is_queued_again = await run.run(slot)
        finally:
            self._attempts.pop(run.job.id, None)
            run.concluded.set()
        if run.ended is not None and self._on_end is not None:
            self._on_end(run.ended.summary)
        if is_queued_again:
            job = replace(run.job, is_cancel_requested=run.is_cancel_requested)
            self._enqueue(job, run.controls, place[0])

    def _end_runs(self, reason: str) -> None:
        self._scheduler.pause()
        for run in self._attempts.values():
            if run.has_begun:
                run.interrupt(reason)

    async def _read_events(self, identifier: str, after: int) -> EventBatch[LoggedEvent]:
        return await asyncio.to_thread(self._store.events_after, identifier, after)
