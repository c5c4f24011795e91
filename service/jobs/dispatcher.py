"""Dispatcher: takes jobs from the table to the slots and their ends back to the table."""

import asyncio
import json
from collections.abc import AsyncGenerator, Mapping
from contextlib import aclosing
from functools import partial
from typing import Any

from planning.errors import Canceled, DeadlineExceeded
from service.events.bus import EventBus, Stretch
from service.jobs.errors import InternalError, ServerRestarted
from service.jobs.floor import Floor
from service.jobs.job_run import JobRun
from service.jobs.lane import Lane
from service.jobs.outcome import Crashed, Outcome, Returned, TimedOut, error_of
from service.jobs.ownership import Ownership
from service.jobs.recorder import NoSink
from service.jobs.records import Job, JobSpec, LoggedEvent
from service.jobs.slot import Run, Slot
from service.jobs.states import JobState
from service.jobs.store import JobStore
from service.jobs.writer import Writer

# No stream is longer; it also fits into every database's integers.
_END_OF_STREAM = 2**31 - 1
_CALL_ATTEMPTS = 2


class Dispatcher:
    """Runs every job of one database, from one event loop."""

    def __init__(self, store: JobStore, ownership: Ownership, lanes: Mapping[str, Lane]) -> None:
        """Put the parts together; `start` begins."""
        self._store = store
        self._ownership = ownership
        self._floor = Floor(lanes)
        self._bus: EventBus[LoggedEvent] = EventBus(self._stretch)
        self._runs: dict[str, JobRun] = {}
        self._num_calls = 0
        self._writer: Writer

    async def start(self, warm_up: str | None = None) -> None:
        """Take the database, recover what an earlier server left, and begin to warm the slots.

        Args:
            warm_up: A task that every process runs first.

        Raises:
            DatabaseInUse: Another dispatcher has the database.
        """
        self._ownership.take()
        try:
            self._store.open()
            self._writer = Writer(self._store)
            await self._floor.open(warm_up)
            for job in self._store.unfinished():
                self._recover(job)
        except BaseException:
            self._ownership.release()
            raise

    async def stop(self) -> None:
        """End every slot and release the database; what ran is queued again if it may be.

        That it was interrupted does not count as an attempt.
        """
        self._bus.close()
        interrupted = [run.job for run in self._runs.values()]
        await self._floor.close()
        await self._writer.close()
        for job in interrupted:
            if job.max_attempts > 1:
                self._store.requeue(job.id, "the server stopped", refund=1)
            else:
                self._store.fail(job.id, _restarted(job.attempts + 1))
        self._ownership.release()

    def submit(self, spec: JobSpec) -> Job:
        """Queue a job; it is durable when this returns.

        Raises:
            QueueFull: Its lane has as many waiting jobs as it may.
            IdempotencyConflict: Its key was used for another request.
        """
        known = spec.key and self._store.known(spec.lane, spec.key, spec.request_digest)
        if known:
            return known
        self._floor.require_room(spec.lane)
        job, is_new = self._store.insert(spec)
        if is_new:
            self._enqueue(job)
        return job

    def cancel(self, identifier: str) -> Job:
        """Ask for the end of a job, whatever its state, and return it; again does no harm.

        A queued job ends at once. A running one is asked, and its process ended if need be; wait
        for it. One that returns its result all the same has succeeded.

        Raises:
            UnknownJob: There is none.
        """
        job = self._store.request_cancel(identifier)
        if job.state.is_final:
            return job
        if job.state is JobState.QUEUED:
            self._floor.lane(job.lane).remove(identifier)
            moved = self._store.cancel_queued(identifier, Canceled("canceled on request"))
            if moved is not None:
                self._bus.publish(identifier, [moved.event])
        if identifier in self._runs:
            self._runs[identifier].cancel()
        return self._store.get(identifier)

    async def wait(self, identifier: str, seconds: float) -> Job:
        """Return a job when it has ended, or as it is after so many seconds.

        Raises:
            UnknownJob: There is none.
        """
        try:
            async with (
                asyncio.timeout(seconds),
                aclosing(self._bus.follow(identifier, _END_OF_STREAM)) as nothing,
            ):
                async for _ in nothing:
                    pass
        except TimeoutError:
            pass
        return await asyncio.to_thread(self._store.get, identifier)

    async def subscribe(self, identifier: str, after: int = 0) -> AsyncGenerator[LoggedEvent]:
        """Yield a job's events with numbers above `after`, each once, until it has ended.

        Raises:
            UnknownJob: There is none.
        """
        async with aclosing(self._bus.follow(identifier, min(after, _END_OF_STREAM))) as events:
            async for event in events:
                yield event

    async def call(
        self, task: str, payload: dict[str, Any], *, lane: str, allowed: float, warm_key: str = ""
    ) -> Any:
        """Run a short task that nobody needs to remember, and return what it returns.

        Raises:
            WayproofError: What the task raised.
            QueueFull: As many wait as may.
            DeadlineExceeded: No slot was free, or the task took too long.
            WorkerCrashed: Its process died, twice.
        """
        self._floor.require_room(lane)
        until = asyncio.get_running_loop().time() + allowed
        for attempt in range(1, _CALL_ATTEMPTS + 1):
            outcome = await self._call_once(task, payload, lane, until, warm_key or None)
            if isinstance(outcome, Returned):
                return json.loads(outcome.result.text)
            if isinstance(outcome, TimedOut):
                message = f"no answer within {allowed:g} s"
                raise DeadlineExceeded(message, {"allowed": allowed, "during": "worker"})
            if not isinstance(outcome, Crashed) or attempt == _CALL_ATTEMPTS:
                raise error_of(outcome, attempt)
        raise AssertionError

    async def _call_once(
        self, task: str, payload: dict[str, Any], lane: str, until: float, warm_key: str | None
    ) -> Outcome:
        loop = asyncio.get_running_loop()
        seated: asyncio.Future[Slot] = loop.create_future()
        self._num_calls += 1
        ticket = f"call {self._num_calls}"
        self._floor.seat(lane, ticket, partial(self._sit, lane, seated), warm_key=warm_key)
        try:
            async with asyncio.timeout_at(until):
                slot = await seated
        except (TimeoutError, asyncio.CancelledError) as ended:
            self._floor.lane(lane).remove(ticket)
            if seated.done() and not seated.cancelled():
                self._floor.readmit(lane, seated.result())
            if isinstance(ended, TimeoutError):
                return TimedOut(0.0)
            raise
        began = loop.time()
        outcome: Outcome | None = None
        try:
            outcome = await slot.run(Run(task, payload, NoSink(), max(0.0, until - began)))
            return outcome
        finally:
            self._floor.release(lane, slot, outcome, loop.time() - began)

    def _sit(self, lane: str, seated: asyncio.Future[Slot], slot: Slot) -> None:
        """Hand a slot to a call; take it back if the call waits no longer."""
        if seated.done():
            self._floor.readmit(lane, slot)
        else:
            seated.set_result(slot)

    def _enqueue(self, job: Job, order: int | None = None) -> None:
        """Run a queued job when it has a slot; if its process dies it keeps its place."""
        place: list[int] = []

        def use(slot: Slot) -> None:
            run = JobRun(job, self._store, self._writer, self._bus, self._floor)
            self._runs[job.id] = run
            self._floor.spawn(self._run(run, slot, place))

        place.append(0 if order is None else order)
        place[0] = self._floor.seat(
            job.lane, job.id, use, warm_key=job.warm_key, priority=job.priority, order=order
        )

    async def _run(self, run: JobRun, slot: Slot, place: list[int]) -> None:
        try:
            is_queued_again = await run.run(slot)
        finally:
            del self._runs[run.job.id]
        if is_queued_again:
            self._enqueue(run.job, place[0])

    def _recover(self, job: Job) -> None:
        """Queue again what was queued, and what ran if it may run again."""
        if job.is_cancel_requested:
            self._store.cancel(job.id, Canceled("canceled on request"))
        elif job.lane not in self._floor:
            self._store.fail(job.id, InternalError(f"this server has no lane {job.lane!r}"))
        elif job.state is JobState.QUEUED:
            self._enqueue(job)
        elif job.attempts < job.max_attempts:
            self._store.requeue(job.id, "the server ended while this ran")
            self._enqueue(job)
        else:
            self._store.fail(job.id, _restarted(job.attempts))

    async def _stretch(self, identifier: str, after: int) -> Stretch[LoggedEvent]:
        return await asyncio.to_thread(self._store.stretch, identifier, after)


def _restarted(attempts: int) -> ServerRestarted:
    return ServerRestarted("the server ended while this ran", {"attempts": attempts})
