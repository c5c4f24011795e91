"""Calls: short tasks that workers run at once, and that need no record."""

import asyncio
from dataclasses import dataclass
from functools import partial
from typing import Any

from planning.errors import DeadlineExceeded
from service.jobs.dispatch.crash import Run, note_crash
from service.jobs.dispatch.scheduling.durations import CallKind
from service.jobs.dispatch.scheduling.scheduler import Scheduler
from service.jobs.dispatch.scheduling.waiting import QueueEntry
from service.jobs.dispatch.spans import run_traced
from service.jobs.errors import WORKER, QueueTimeout
from service.jobs.event_buffer import NullSink
from service.jobs.json_steps import STEP, decode
from service.jobs.json_text import Encoded, decode_parts, encode
from service.jobs.outcome import Crashed, Lost, Outcome, Returned, TimedOut, error_of
from service.jobs.task import artifacts_of
from service.jobs.worker.assignment import Assignment, Worker
from service.telemetry.ids import bound_ids

_ATTEMPTS = 2


@dataclass(frozen=True)
class Call:
    """A short task to run.

    Attributes:
        task: Its name.
        payload: What it is called with.
        queue: Which workers may run it.
        time_limit: For the work [s]; what it waits for a worker does not count.
        worker_timeout: How long it waits for a worker [s].
        world_digest: Workers that have this scene loaded are preferred.
        size: How much is requested: lists with twice as many items take longer.
        digest_field: Of a task that loads a scene, the field of its result that has the digest.
        is_raw: Whether the result is wanted as the JSON that the task gave.
        is_partly_raw: Whether the members that the task encoded itself are wanted as they are.
        client: Whom it is for: clients take turns.
    """

    task: str
    payload: dict[str, Any]
    queue: str
    time_limit: float
    worker_timeout: float
    world_digest: str | None = None
    size: int = 0
    digest_field: str = ""
    is_raw: bool = False
    is_partly_raw: bool = False
    client: str = ""

    @property
    def kind(self) -> CallKind:
        """What it has in common with calls that take about as long."""
        return CallKind(self.task, self.size.bit_length(), is_load=bool(self.digest_field))


@dataclass(frozen=True)
class CallResult:
    """What a short task returned.

    Attributes:
        content: Decoded JSON, or `Encoded` if it is raw, or an object of both.
        waited: For a worker [s].
        worked: In the worker [s].
    """

    content: Any
    waited: float
    worked: float


@dataclass(frozen=True)
class _Finished:
    outcome: Outcome
    content: Any
    seconds: float


class Calls:
    """Runs short tasks in the workers of a scheduler."""

    def __init__(self, scheduler: Scheduler) -> None:
        """Use the workers of `scheduler`."""
        self._scheduler = scheduler
        self._num_calls = 0

    async def run(self, call: Call) -> CallResult:
        """Run a task and return its result; canceled, it is told to end, and soon after killed.

        Raises:
            WayproofError: What the task raised.
            QueueFull: As many wait as may.
            QueueTimeout: No worker was free in time.
            DeadlineExceeded: The task took too long.
            WorkerCrashed: Its process died, twice.
            HostLost: Its machine was lost, twice.
        """
        self._scheduler.check_room(call.queue, call.client)
        loop = asyncio.get_running_loop()
        waited = 0.0
        attempt = 0
        while True:
            came = loop.time()
            worker = await self._worker_for(call)
            waited += loop.time() - came
            finished = await self._shielded_run(call, worker, attempt + 1)
            outcome = finished.outcome
            # Where it never began, it was not tried.
            attempt += not isinstance(outcome, Lost) or outcome.has_begun
            if isinstance(outcome, Returned):
                return CallResult(finished.content, waited, finished.seconds)
            if isinstance(outcome, TimedOut):
                message = f"no answer within {call.time_limit:g} s"
                evidence = {"allowed": call.time_limit, "during": WORKER, "waited": waited}
                raise DeadlineExceeded(message, evidence).in_stage(WORKER)
            if not isinstance(outcome, Crashed | Lost) or attempt == _ATTEMPTS:
                raise error_of(outcome, attempt)

    async def _worker_for(self, call: Call) -> Worker:
        """Return a worker as soon as there is one.

        Raises:
            QueueTimeout: There was none in time.
        """
        granted: asyncio.Future[Worker] = asyncio.get_running_loop().create_future()
        self._num_calls += 1
        entry = QueueEntry(
            name=f"call {self._num_calls}",
            place=self._scheduler.next_place(call.queue),
            use=partial(self._assign, call.queue, granted),
            world_digest=call.world_digest,
            client=call.client,
            kind=call.kind,
        )
        self._scheduler.request(call.queue, entry)
        try:
            async with asyncio.timeout(call.worker_timeout):
                return await granted
        except (TimeoutError, asyncio.CancelledError) as ended:
            self._scheduler.queue(call.queue).remove(entry.name)
            if granted.done() and not granted.cancelled():
                self._scheduler.return_worker(call.queue, granted.result())
            if isinstance(ended, TimeoutError):
                raise self._timeout_error(call) from ended
            raise

    async def _shielded_run(self, call: Call, worker: Worker, attempt: int) -> _Finished:
        """Run the task; if it is not waited for any more, it ends, and the worker is free again."""
        work = asyncio.get_running_loop().create_task(self._run_in(call, worker, attempt))
        self._scheduler.keep(work)
        try:
            return await asyncio.shield(work)
        except asyncio.CancelledError:
            worker.cancel(self._scheduler.queue(call.queue).cancel_grace)
            raise

    async def _run_in(self, call: Call, worker: Worker, attempt: int) -> _Finished:
        loop = asyncio.get_running_loop()
        began = loop.time()
        run = Assignment(
            call.task, Encoded(encode(call.payload)), NullSink(), call.time_limit, ids=bound_ids()
        )
        content: Any = None
        try:
            await worker.bring(artifacts_of(call.task, call.payload))
            outcome = await run_traced(worker, run)
            note_crash(outcome, Run(call.queue, call.task, attempt), self._scheduler.observer)
            if isinstance(outcome, Returned):
                content = await self._content(call, outcome.result)
            return _Finished(outcome, content, loop.time() - began)
        finally:
            seconds = loop.time() - began
            if call.digest_field and content is not None:
                queue, digest = self._scheduler.queue(call.queue), content[call.digest_field]
                queue.pool.warm(worker, digest)
                queue.durations.record_load(digest, seconds)
            self._scheduler.release(call.queue, worker, seconds)

    @staticmethod
    async def _content(call: Call, result: Encoded) -> Any:
        if call.is_raw:
            return result
        read = decode_parts if call.is_partly_raw else decode
        if len(result.text) <= STEP:
            return read(result.text)
        # What is large is decoded elsewhere: nothing else would be answered meanwhile.
        return await asyncio.to_thread(read, result.text)

    def _assign(self, queue: str, granted: asyncio.Future[Worker], worker: Worker) -> None:
        """Hand a worker to a call; take it back if the call waits no longer."""
        if granted.done():
            self._scheduler.return_worker(queue, worker)
        else:
            granted.set_result(worker)

    def _timeout_error(self, call: Call) -> QueueTimeout:
        queue = self._scheduler.queue(call.queue)
        message = f"no worker was free within {call.worker_timeout:g} s; try again later"
        evidence = {
            "queue": queue.name,
            "waited": call.worker_timeout,
            "queued": queue.num_waiting,
            "retry_after": queue.retry_after(asyncio.get_running_loop().time()),
        }
        return QueueTimeout(message, evidence)
