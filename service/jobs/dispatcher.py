"""Dispatcher: takes jobs from the table to the slots and their ends back to the table."""

import asyncio
from collections import defaultdict
from collections.abc import AsyncIterator, Mapping
from typing import Any

from planning.errors import Canceled
from service.jobs.errors import InternalError, QueueFull, ServerRestarted
from service.jobs.lane import Lane
from service.jobs.outcome import (
    Crashed,
    Ended,
    Outcome,
    Raised,
    Returned,
    TimedOut,
    canceled_failure,
    error_of,
    failure_of,
    value_of,
)
from service.jobs.ownership import Ownership
from service.jobs.records import Job, JobSpec, LoggedEvent
from service.jobs.slot import Run, Slot
from service.jobs.states import JobEvent, JobState
from service.jobs.store import JobStore

_RETRY_AFTER = 2.0


class Dispatcher:
    """Runs every job of one database, from one event loop."""

    def __init__(self, store: JobStore, ownership: Ownership, lanes: Mapping[str, Lane]) -> None:
        """Put the parts together; `start` begins."""
        self._store = store
        self._ownership = ownership
        self._lanes = lanes
        self._running: dict[str, Slot] = {}
        self._news: dict[str, set[asyncio.Event]] = defaultdict(set)
        self._tasks: set[asyncio.Task[Any]] = set()
        self._slot_freed = {name: asyncio.Condition() for name in lanes}

    async def start(self, warm_up: str | None = None) -> None:
        """Take the database, recover what an earlier server left, and warm the slots.

        Args:
            warm_up: A task that every slot runs first.

        Raises:
            DatabaseInUse: Another dispatcher has the database.
        """
        self._ownership.take()
        self._store.open()
        if warm_up is not None:
            for lane in self._lanes.values():
                for _ in lane.slots:
                    self._spawn(self._warm(lane, lane.take_slot(None), warm_up))
        for job in self._store.unfinished():
            self._recover(job)
        self._pump()

    async def stop(self) -> None:
        """End every slot and release the database; running jobs are recovered at the next start."""
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        slots = [slot for lane in self._lanes.values() for slot in lane.slots]
        await asyncio.gather(*(slot.close() for slot in slots))
        self._ownership.release()

    def submit(self, spec: JobSpec) -> Job:
        """Queue a job; it is durable when this returns.

        Raises:
            QueueFull: Its lane has as many waiting jobs as it may.
            IdempotencyConflict: Its key was used for another request.
        """
        lane = self._lanes[spec.lane]
        known = spec.key and self._store.known(spec.lane, spec.key, spec.request_digest)
        if known:
            return known
        if lane.is_full:
            message = f"{lane.num_waiting} jobs wait for {lane.name} already; try again later"
            evidence = {"lane": lane.name, "bound": lane.max_waiting, "retry_after": _RETRY_AFTER}
            raise QueueFull(message, evidence)
        job, is_new = self._store.insert(spec)
        if is_new:
            lane.add(job)
            self._pump()
        return job

    def cancel(self, identifier: str) -> Job:
        """Ask for the end of a job, whatever its state, and return it; again does no harm.

        A queued job ends at once. A running one is asked, and its process ended if need be; wait
        for it.

        Raises:
            UnknownJob: There is none.
        """
        job = self._store.request_cancel(identifier)
        if job.state is JobState.QUEUED:
            self._lanes[job.lane].remove(identifier)
            self._finish(job, JobEvent.CANCEL, failure=canceled_failure())
        elif identifier in self._running:
            self._running[identifier].cancel(self._lanes[job.lane].cancel_grace)
        return self._store.get(identifier)

    async def wait(self, identifier: str, seconds: float) -> Job:
        """Return a job when it has ended, or as it is after so many seconds.

        Raises:
            UnknownJob: There is none.
        """
        job = self._store.get(identifier)
        news = asyncio.Event()
        self._news[identifier].add(news)
        try:
            async with asyncio.timeout(seconds):
                while not job.state.is_final:
                    job = self._store.get(identifier)
                    if not job.state.is_final:
                        await news.wait()
                        news.clear()
        except TimeoutError:
            job = self._store.get(identifier)
        finally:
            self._forget(identifier, news)
        return job

    async def subscribe(self, identifier: str, after: int = 0) -> AsyncIterator[LoggedEvent]:
        """Yield a job's events with numbers above `after`, each once, until it has ended.

        Raises:
            UnknownJob: There is none.
        """
        news = asyncio.Event()
        self._news[identifier].add(news)
        try:
            while True:
                is_final = self._store.get(identifier).state.is_final
                for event in self._store.events(identifier, after):
                    after = event.number
                    yield event
                if is_final:
                    return
                await news.wait()
                news.clear()
        finally:
            self._forget(identifier, news)

    async def call(
        self, task: str, payload: dict[str, Any], *, lane: str, allowed: float, warm_key: str = ""
    ) -> Any:
        """Run a short task that nobody needs to remember, and return what it returns.

        Raises:
            WayproofError: What the task raised.
            DeadlineExceeded: No slot was free, or the task took too long.
            WorkerCrashed: Its process died, twice.
        """
        for attempt in (1, 2):
            outcome = await self._call_once(Run(task, payload, _ignore, allowed), lane, warm_key)
            if not isinstance(outcome, Crashed) or attempt == 2:
                return value_of(outcome, attempt)
        message = "unreachable: the second attempt returns"
        raise AssertionError(message)

    async def _call_once(self, run: Run, lane_name: str, warm_key: str) -> Outcome:
        lane, freed = self._lanes[lane_name], self._slot_freed[lane_name]
        try:
            async with asyncio.timeout(run.allowed), freed:
                await freed.wait_for(lambda: lane.has_idle_slot)
                slot = lane.take_slot(warm_key or None)
        except TimeoutError:
            return TimedOut(run.allowed or 0.0)
        try:
            return await slot.run(run)
        except asyncio.CancelledError:
            slot.cancel(0.0)
            raise
        finally:
            await self._give_back(lane, slot)

    def _recover(self, job: Job) -> None:
        """Queue again what was queued, and what ran if it may run again."""
        if job.is_cancel_requested:
            self._finish(job, JobEvent.CANCEL, failure=canceled_failure())
        elif job.state is JobState.QUEUED:
            self._lanes[job.lane].add(job)
        elif job.attempts < job.max_attempts:
            self._queue_again(job)
        else:
            error = ServerRestarted("the server ended while this ran", {"attempts": job.attempts})
            self._finish(job, JobEvent.FAIL, failure=failure_of(error))

    def _pump(self) -> None:
        """Start every job that has a slot."""
        for lane in self._lanes.values():
            while (pair := lane.take()) is not None:
                self._spawn(self._run(lane, *pair))

    async def _run(self, lane: Lane, job: Job, slot: Slot) -> None:
        """Run one job to its end."""
        try:
            started = self._store.move(job.id, JobEvent.START)
            if started is None or started.is_cancel_requested:
                self._finish(job, JobEvent.CANCEL, failure=canceled_failure())
                return
            self._running[job.id] = slot
            self._tell(job.id)

            def on_event(type_: str, data: dict[str, Any]) -> None:
                if self._store.record(job.id, type_, data) is not None:
                    self._tell(job.id)

            outcome = await slot.run(Run(job.task, job.payload, on_event, job.allowed))
            self._conclude(started, outcome)
        except Exception as fault:  # noqa: BLE001  (no job may stay "running" for ever)
            error = InternalError(f"the dispatcher failed: {fault!r}"[:500])
            self._finish(job, JobEvent.FAIL, failure=failure_of(error))
        finally:
            self._running.pop(job.id, None)
            await self._give_back(lane, slot)

    def _conclude(self, job: Job, outcome: Outcome) -> None:
        """Write a run's end into the table; a job whose process died may run again."""
        is_unwanted = self._store.get(job.id).is_cancel_requested
        match outcome:
            case Returned(result=result):
                self._finish(job, JobEvent.SUCCEED, result=result)
            case Raised(error=error):
                happened = JobEvent.CANCEL if isinstance(error, Canceled) else JobEvent.FAIL
                self._finish(job, happened, failure=failure_of(error))
            case Ended():
                self._finish(job, JobEvent.CANCEL, failure=canceled_failure())
            case Crashed() | TimedOut() if is_unwanted:
                self._finish(job, JobEvent.CANCEL, failure=canceled_failure())
            case Crashed() if job.attempts < job.max_attempts:
                self._queue_again(job)
            case Crashed() | TimedOut():
                error = error_of(outcome, job.attempts)
                self._finish(job, JobEvent.FAIL, failure=failure_of(error))

    def _queue_again(self, job: Job) -> None:
        again = self._store.move(job.id, JobEvent.REQUEUE)
        if again is not None:
            self._lanes[job.lane].add(again)
        self._tell(job.id)

    def _finish(
        self,
        job: Job,
        event: JobEvent,
        *,
        result: dict[str, Any] | None = None,
        failure: dict[str, Any] | None = None,
    ) -> None:
        self._store.move(job.id, event, result=result, failure=failure)
        self._tell(job.id)

    async def _warm(self, lane: Lane, slot: Slot, task: str) -> None:
        try:
            await slot.run(Run(task, {}, _ignore))
        finally:
            await self._give_back(lane, slot)

    async def _give_back(self, lane: Lane, slot: Slot) -> None:
        freed = self._slot_freed[lane.name]
        lane.give_back(slot)
        self._pump()
        async with freed:
            freed.notify_all()

    def _tell(self, identifier: str) -> None:
        for news in self._news.get(identifier, ()):
            news.set()

    def _forget(self, identifier: str, news: asyncio.Event) -> None:
        self._news[identifier].discard(news)
        if not self._news[identifier]:
            del self._news[identifier]

    def _spawn(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


def _ignore(_: str, __: dict[str, Any]) -> None:
    """Do nothing with an event."""
