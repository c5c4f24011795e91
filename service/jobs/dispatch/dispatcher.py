"""Dispatcher: takes jobs from the table to the workers and their ends back to the table."""

import asyncio
import logging
from collections.abc import AsyncGenerator, Callable, Mapping, Sequence
from contextlib import AbstractContextManager, aclosing
from typing import Any, Literal

from service.errors import ServerStopping
from service.jobs.dispatch.attempt import Attempt
from service.jobs.dispatch.attempts import Attempts
from service.jobs.dispatch.calls import Call, CallResult, Calls
from service.jobs.dispatch.conclusion import Conclusion, NoConclusion
from service.jobs.dispatch.leadership.join import join
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.dispatch.leadership.lock_watch import LockWatch, Standby
from service.jobs.dispatch.leadership.timeouts import DatabaseTimeouts
from service.jobs.dispatch.observer import Observer
from service.jobs.dispatch.recorder import JobRecorder
from service.jobs.dispatch.recovery import Recovery
from service.jobs.dispatch.release import JobRelease
from service.jobs.dispatch.requests import JobControl, JobSubmission
from service.jobs.dispatch.scheduling.queue import JobQueue
from service.jobs.dispatch.scheduling.scheduler import QueueLoad, Scheduler
from service.jobs.dispatch.shutdown import STOPPED, Shutdown
from service.jobs.dispatch.uptake import Uptake
from service.jobs.dispatch.waits import END_OF_STREAM, JobWaits
from service.jobs.event_bus import EventBatch, EventBus
from service.jobs.job import Job, JobSpec, JobSummary, JobText, LoggedEvent
from service.jobs.store.job_store import JobStore

_log = logging.getLogger(__name__)


def _nothing() -> None:
    pass


class Dispatcher:
    """Runs every job of one database if it leads, or has the one that leads run them.

    Whichever it is, it takes in jobs, follows and controls them, and runs short tasks; from one
    event loop.

    Attributes:
        is_taken: Whether another server has taken the database over.
        leads: Set once it leads.
        waiting: Releases jobs that wait for their robots, once it leads.
        on_success: Awaited when the task of a job has returned, before its end is recorded; what
            it raises is the failure of the job.
    """

    def __init__(
        self,
        store: JobStore,
        lock: DispatcherLock,
        queues: Mapping[str, JobQueue],
        *,
        on_taken: Callable[[], None] = _nothing,
        observer: Observer | None = None,
        timeouts: DatabaseTimeouts | None = None,
    ) -> None:
        """Put the parts together; `start` begins.

        Args:
            store: The record of jobs.
            lock: On the database.
            queues: Where jobs wait, by name.
            on_taken: Called once when another server has taken the database over.
            observer: Hears of what gets a worker, and of what has ended here.
            timeouts: How long a database may be out of reach.
        """
        self.is_taken = self._is_stopping = False
        self.leads = asyncio.Event()
        self._on_taken = on_taken
        self.conclusion: Conclusion = NoConclusion()
        self._observer = observer or Observer()
        self._timeouts = timeouts or DatabaseTimeouts()
        self._store = store
        self._lock = lock
        self._scheduler = Scheduler(queues, self._observer)
        self._bus: EventBus[LoggedEvent] = EventBus(self._read_events)
        self._calls = Calls(self._scheduler)
        self._recorder: JobRecorder
        self._attempts: Attempts
        self._shutdown: Shutdown
        self._waits: JobWaits
        self._control: JobControl
        self._submission: JobSubmission
        self._recovery: Recovery
        self._uptake: Uptake
        self.waiting: JobRelease

    @property
    def role(self) -> Literal["leader", "follower"]:
        """What it is among the servers of the database."""
        return "leader" if self.leads.is_set() else "follower"

    async def start(self, warm_up: str | None = None) -> None:
        """Take the database and recover what an earlier server left, or follow the one that leads.

        The workers begin to get warm.

        Args:
            warm_up: A task that every process runs first.

        Raises:
            DatabaseInUse: Another dispatcher has the database, which cannot be shared.
            DatabaseTooNew: A newer version has changed it.
        """
        await asyncio.to_thread(self._store.refuse_newer)
        is_first = await join(self._store, self._lock, self._timeouts)
        try:
            self._put_together()
            await self._scheduler.open(warm_up)
            if is_first:
                await self._lead()
        except BaseException:
            await asyncio.to_thread(self._lock.release)
            raise
        if self._store.is_shared:
            self._scheduler.spawn(self._store.listener(self._uptake.note).run())
            self._scheduler.spawn(self._uptake.run(self.leads.is_set, self._timeouts.poll))
        if not is_first:
            self._scheduler.spawn(self._stand_by())

    def _put_together(self) -> None:
        """Make what belongs to the running event loop."""
        store, scheduler, within = self._store, self._scheduler, self._timeouts.record
        recorder = self._recorder = JobRecorder(store, self._bus, self.give_up)
        attempts = self._attempts = Attempts(
            recorder, scheduler, self._observer, lambda: self.conclusion
        )
        self._shutdown = Shutdown(attempts, scheduler)
        self._waits = JobWaits(attempts, self._bus, store)
        self._control = JobControl(attempts, recorder, scheduler, within)
        self._submission = JobSubmission(recorder, attempts, scheduler, within)
        self._recovery = Recovery(
            recorder, self._lock, scheduler, attempts.enqueue, self.conclusion
        )
        self._uptake = Uptake(recorder, self._bus, attempts, self._control, self._recovery)
        self.waiting = JobRelease(recorder, self._recovery.take_up, self._uptake.note)

    async def _lead(self) -> None:
        """Take up what the table has, and run every job from now on."""
        await self._recovery.run(self._timeouts.takeover)
        self.leads.set()
        self._uptake.note(None)  # what came since the table was read
        if self._lock.may_be_lost:
            self._scheduler.spawn(LockWatch(self._lock, self, self._timeouts).run())

    async def _stand_by(self) -> None:
        """Follow until the one that leads is gone, then lead."""
        await Standby(self._lock, self._timeouts).take()
        if self.is_draining:  # it is given back at once
            return
        _log.warning("this server leads from now on")
        try:
            await asyncio.to_thread(self._store.refuse_newer)
            self._store.set_epoch(self._lock.epoch)
            await self._lead()
        except Exception:  # noqa: BLE001  (whatever it is, another server may do better)
            _log.exception("the jobs of the database could not be taken up")
            self.give_up()

    async def stop(self) -> None:
        """Bring what runs to its end, end every worker and release the database.

        What was interrupted is queued again if it may run again; that does not count as an attempt.
        """
        self.begin_to_stop()
        if late := await self._shutdown.concluded():
            _log.error("the ends of %d jobs could not be recorded", late)
        self._bus.close()
        await self._scheduler.close()
        await self._recorder.close()
        await asyncio.to_thread(self._lock.release)

    @property
    def is_draining(self) -> bool:
        """Whether no job may begin any more, because the server is to end."""
        return self._shutdown.is_draining

    async def drain(self) -> None:
        """Take and begin no more jobs, and wait for those that run; robots come to rest at once."""
        self._shutdown.begin_to_drain()
        await self._shutdown.drained()

    def begin_to_stop(self) -> None:
        """Begin nothing more, and tell what runs to end: a robot comes to rest on its path.

        Every wait for a job is answered at once: what waited would be cut off.
        """
        self._is_stopping = True
        self._bus.wake_all()
        self._waits.end()
        self._shutdown.begin_to_drain()
        self._shutdown.interrupt_all(STOPPED)

    def suspend(self) -> None:
        """Begin nothing, and end what runs: the database may be another's by now."""
        self._shutdown.interrupt_all("the database was out of reach")

    def resume(self) -> None:
        """Work again after `suspend`."""
        self._scheduler.resume()

    def give_up(self) -> None:
        """End what runs, and do nothing more: another has the database."""
        if not self.is_taken:
            self.is_taken = True
            _log.critical("another server has taken the database over: this one gives up")
            self._shutdown.interrupt_all("another server took the database over")
            self._on_taken()

    def attempt_of(self, identifier: str) -> Attempt | None:
        """Return what memory has of a job that waits or runs here, None if it does not."""
        return self._attempts.get(identifier)

    def loads(self) -> dict[str, QueueLoad]:
        """Return what waits and what works, by queue."""
        return self._scheduler.loads()

    def faults(self) -> dict[str, str]:
        """Return why queues cannot begin a job well, by name; empty if all can."""
        return self._scheduler.faults()

    async def submit(self, spec: JobSpec) -> Job:
        """Queue a job; see `submit_all`."""
        return (await self.submit_all([spec]))[0]

    async def submit_all(self, specs: Sequence[JobSpec]) -> list[Job]:
        """Queue jobs of one queue, all or none; see `JobSubmission.submit_all`.

        Raises:
            QueueFull: Its queue would have more waiting jobs than it may.
            ServerStopping: The server is to end.
        """
        first = specs[0]
        request = (first.queue, first.key or "", first.request_digest)
        if first.key and (known := await asyncio.to_thread(self._store.find_by_key, *request)):
            return [known]
        if self.is_draining:
            message = "the server is about to end and takes no more jobs; ask again when it is back"
            raise ServerStopping(message)
        self._scheduler.check_room(first.queue, first.client, len(specs))
        if self.leads.is_set() and not first.waits:
            return await self._submission.submit_all(specs)
        jobs = await self._submission.pass_on_all(specs)
        if self.leads.is_set() and not first.waits:  # meanwhile
            self._uptake.note([job.id for job in jobs])
        return jobs

    async def cancel(self, identifier: str) -> JobSummary:
        """End a job and return it; see `JobControl.cancel`."""
        return await self._control.cancel(identifier)

    async def control(self, identifier: str, controls: Mapping[str, Any]) -> Job:
        """Set controls of a job and return it; see `JobControl.control`."""
        return await self._control.control(identifier, controls)

    async def wait(self, identifier: str, seconds: float) -> Job:
        """Return a job when it has ended; see `JobWaits.whole`."""
        return await self._waits.whole(identifier, seconds)

    async def wait_text(self, identifier: str, seconds: float) -> JobText:
        """Return a job when it has ended, its result as text; see `JobWaits.text`."""
        return await self._waits.text(identifier, seconds)

    async def subscribe(self, identifier: str, after: int = 0) -> AsyncGenerator[LoggedEvent]:
        """Yield a job's events with numbers above `after`, each once, until it has ended.

        Raises:
            UnknownJob: There is none.
        """
        async with aclosing(self._bus.follow(identifier, min(after, END_OF_STREAM))) as events:
            async for event in events:
                yield event

    def watch(self, name: str) -> AbstractContextManager[Callable[[], asyncio.Event]]:
        """Watch what has a name, of a job or another one; see `EventBus.watch`."""
        return self._bus.watch(name)

    def wake(self, name: str) -> None:
        """Tell those who watch a name that it has changed."""
        self._bus.wake(name)

    @property
    def is_stopping(self) -> bool:
        """Whether the server ends: what is watched is told no more."""
        return self._is_stopping

    async def call(self, call: Call) -> CallResult:
        """Run a short task that needs no record, and return what it returns; see `Calls.run`."""
        return await self._calls.run(call)

    async def _read_events(self, identifier: str, after: int) -> EventBatch[LoggedEvent]:
        return await asyncio.to_thread(self._store.events_after, identifier, after)
