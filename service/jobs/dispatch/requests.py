"""What clients request of jobs: that one runs, that it ends, or that it goes on in another way."""

import asyncio
from collections.abc import Callable, Coroutine, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from typing import Any

from planning.errors import Canceled, IllegalTransition
from service.jobs.dispatch.attempt import Attempt
from service.jobs.dispatch.attempts import Attempts
from service.jobs.dispatch.recorder import JobRecorder
from service.jobs.dispatch.scheduling.scheduler import Scheduler
from service.jobs.errors import DatabaseTaken, QueueFull
from service.jobs.job import CONTROLS, Job, JobSpec, JobSummary, JobText
from service.jobs.states import JobState
from service.jobs.store.drafts import Draft, draft
from service.jobs.store.transitions import Transition

# How long an answer waits for the database [s]; what is not written by then is written later.
_PROMPT = 0.5


@dataclass(frozen=True)
class _Written:
    """Jobs as the table has them.

    Attributes:
        jobs: New ones, or the one that their key names.
        are_new: Whether they are new.
        starts: Of those that have begun, by their ids.
    """

    jobs: list[Job]
    are_new: bool
    starts: Mapping[str, Transition | None]


class JobSubmission:
    """Submits jobs, which may run while they are written, and are answered once they are durable.

    To write a job takes a few milliseconds of the disk's, and many a job takes no more. One that
    may run twice does no harm if it ran for nothing, so it begins at once. Nothing of it is
    recorded before the job itself, and what the table refuses leaves no trace. The start of one
    that has begun by then is written with it.

    A server that follows another one writes them all the same, and that one runs them.
    """

    def __init__(
        self, recorder: JobRecorder, attempts: Attempts, scheduler: Scheduler, within: float
    ) -> None:
        """Put the parts together.

        Args:
            recorder: Writes jobs.
            attempts: Runs them.
            scheduler: Has the queues.
            within: How long a job may take to be written; what takes longer is refused [s].
        """
        self._recorder = recorder
        self._attempts = attempts
        self._scheduler = scheduler
        self._within = within

    async def submit(self, spec: JobSpec) -> Job:
        """Queue a job, or return the one that its key names; see `submit_all`."""
        [job] = await self.submit_all([spec])
        return job

    async def submit_all(self, specs: Sequence[JobSpec]) -> list[Job]:
        """Queue jobs, all of them or none; they are durable when this returns.

        Where the key of the first one was used before, the job that it names is returned alone.

        Raises:
            QueueFull: As many wait as may, on all servers together.
            IdempotencyConflict: Its key was used for another request.
            DatabaseUnavailable: The database does not take it in time; it is not queued.
            DBAPIError: The database refuses it.
            TypeError: Its payload is not JSON-compatible.
        """
        drafts = [draft(spec) for spec in specs]
        # In time for what may run twice; a run of what may not waits for its start to be written.
        # One that has a worker is sent to it here, before the thread that writes takes part of the
        # interpreter.
        attempts = [
            self._attempts.schedule(drafted.job, {}, text=drafted.payload) for drafted in drafts
        ]
        try:
            # Not in this thread: while a locked database is waited for, others are to be stopped.
            written = await self._write(drafts, attempts)
        except BaseException:
            self._take_back(attempts)
            raise
        if written.are_new:
            for attempt, job in zip(attempts, written.jobs, strict=True):
                start = written.starts.get(job.id)
                self._recorder.publish(job.id, [] if start is None else [start.event])
                attempt.confirm(job, start)
        else:
            self._take_back(attempts)
        return written.jobs

    def _take_back(self, attempts: Sequence[Attempt]) -> None:
        for attempt in reversed(attempts):  # what waits does not begin because of what ends
            self._attempts.unschedule(attempt)

    async def pass_on_all(self, specs: Sequence[JobSpec]) -> list[Job]:
        """Have the server that leads run jobs; returns and raises as `submit_all`."""
        return (await self._write([draft(spec) for spec in specs], ())).jobs

    async def _write(self, drafts: Sequence[Draft], attempts: Sequence[Attempt]) -> "_Written":
        """Write jobs, and the starts of those that have begun, in one transaction."""
        name = drafts[0].job.queue
        own = {drafted.job.id for drafted in drafts}
        num_starting = self._attempts.num_starting(name, but=own)
        room = self._scheduler.queue(name).max_waiting + num_starting
        retry_after = self._scheduler.retry_after(name)

        def check(num_queued: int) -> None:
            """Go on only if the table has room for all drafts."""
            if num_queued + len(drafts) > room:
                raise QueueFull.of(name, num_queued, room - num_starting, retry_after, len(drafts))

        def insert() -> _Written:
            store = self._recorder.store
            with store.transaction(is_durable=True):
                jobs, are_new = store.insert_drafts(drafts, check)
                begun = [each.job.id for each in attempts if are_new and each.has_start_to_write]
                return _Written(jobs, are_new, {name: store.start(name) for name in begun})

        return await self._recorder.write(insert, within=self._within)


class JobControl:
    """Cancels and controls jobs; an attempt that is here hears of it before the database.

    The server that runs a job reads in the database what others have requested of it.
    """

    def __init__(
        self, attempts: Attempts, recorder: JobRecorder, scheduler: Scheduler, within: float
    ) -> None:
        """Control the attempts that there are; a write for another server takes so long [s]."""
        self._attempts = attempts
        self._recorder = recorder
        self._scheduler = scheduler
        self._within = within
        self._unwritten: dict[str, dict[str, Any]] = {}

    async def cancel(self, identifier: str) -> JobSummary:
        """End a job, whatever its state, and return it; again does no harm.

        A queued job ends at once. A running one is told, and its process ended if need be; wait
        for it. One that returns its result all the same has succeeded. No database is waited for.

        Raises:
            UnknownJob: There is none.
            DBAPIError: It neither waits nor runs, and the database does not answer.
        """
        attempt = self._attempts.get(identifier)
        if attempt is None:
            job = await asyncio.to_thread(self._recorder.store.summary, identifier)
            return job if job.state.is_final else await self._write_cancel(identifier, None)
        self._attempts.cancel(attempt)
        at = attempt.cancel_requested_at
        job = await self._recorded(identifier, "cancel", lambda: self._write_cancel(identifier, at))
        return job or attempt.snapshot()

    async def control(self, identifier: str, controls: Mapping[str, Any]) -> Job:
        """Set controls of a job that waits or runs, and return it.

        Raises:
            IllegalTransition: It has ended, or is to end.
        """
        attempt = self._attempts.get(identifier)
        if attempt is None:  # another server runs it, or it waits for its robots
            return await self._pass_on(identifier, controls)
        if not attempt.is_open:
            raise _not_open(identifier, is_ending=attempt.is_cancel_requested)
        attempt.control(controls)
        self._unwritten.setdefault(identifier, {}).update(controls)
        await self._recorded(identifier, CONTROLS, lambda: self._write_controls(identifier))
        return attempt.snapshot()

    def adopt(self, identifier: str, controls: Mapping[str, Any]) -> None:
        """Set the controls that the table has for a job that waits or runs here."""
        attempt = self._attempts.get(identifier)
        if attempt is not None and attempt.is_open:
            attempt.control({**controls, **self._unwritten.get(identifier, {})})

    async def _pass_on(self, identifier: str, controls: Mapping[str, Any]) -> Job:
        """Set controls of a job that does not run here; returns and raises as `control`."""
        store = self._recorder.store
        job = await asyncio.to_thread(store.get, identifier)
        if job.state.is_final or job.is_cancel_requested:
            raise _not_open(identifier, is_ending=not job.state.is_final)
        write = partial(store.set_controls, identifier, controls)
        logged = await self._recorder.write(write, is_durable=False, within=self._within)
        if not logged:
            raise _not_open(identifier, is_ending=False)
        self._recorder.publish(identifier, logged)
        self.adopt(identifier, logged[-1].data)  # this server may have begun to lead meanwhile
        return job

    async def _recorded[T](
        self, identifier: str, what: str, write: Callable[[], Coroutine[Any, Any, T]]
    ) -> T | None:
        """Return what a write gives, None if it has to be made later."""

        async def record() -> T | None:
            try:
                return await self._recorder.write_until_done(identifier, what, write)
            except DatabaseTaken:
                return None

        work = asyncio.get_running_loop().create_task(record())
        self._scheduler.keep(work)
        done, _ = await asyncio.wait({work}, timeout=_PROMPT)
        return work.result() if done else None

    async def _write_cancel(self, identifier: str, at: datetime | None) -> Job:
        job, ended = await self._recorder.write(partial(self._cancel_in_store, identifier, at))
        if ended is not None:
            self._recorder.publish(identifier, [ended.event])
        attempt = self._attempts.get(identifier)
        if attempt is not None:
            if not attempt.is_cancel_requested:  # this server began to lead meanwhile
                self._attempts.cancel(attempt)
            if ended is not None:
                # One that had a worker already concludes later; who waits is answered now.
                attempt.ended = JobText(job, None)
                self._attempts.drop(attempt)
        return job

    def _cancel_in_store(
        self, identifier: str, at: datetime | None
    ) -> tuple[Job, Transition | None]:
        store = self._recorder.store
        with store.transaction(is_durable=True):
            job = store.request_cancel(identifier, at)
            if job.state is not JobState.QUEUED:
                return job, None
            ended = store.cancel_queued(identifier, Canceled("canceled on request"))
            return store.request_cancel(identifier), ended

    async def _write_controls(self, identifier: str) -> None:
        """Record controls: a job that waits, or runs again, is told again after a restart."""
        attempt = self._attempts.get(identifier)
        if attempt is not None:
            await attempt.record_events()
        changes = dict(self._unwritten.get(identifier, {}))
        if not changes:  # they were written with others
            return
        write = partial(self._recorder.store.set_controls, identifier, changes)
        self._recorder.publish(identifier, await self._recorder.write(write, is_durable=False))
        unwritten = self._unwritten.get(identifier, {})
        for name, content in changes.items():
            if name in unwritten and unwritten[name] == content:
                del unwritten[name]
        if not unwritten:
            self._unwritten.pop(identifier, None)


def _not_open(identifier: str, *, is_ending: bool) -> IllegalTransition:
    state = "canceling" if is_ending else "at its end"
    message = f"job {identifier} is {state}: it cannot be steered any more"
    return IllegalTransition(message, {"state": state, "event": "steer", "legal": []})
