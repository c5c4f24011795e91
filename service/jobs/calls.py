"""Calls: questions that are answered by slots and need no record."""

import asyncio
from dataclasses import dataclass
from functools import partial
from typing import Any

from planning.errors import DeadlineExceeded
from service.jobs.errors import WORKER, QueueTimeout
from service.jobs.event_buffer import NullSink
from service.jobs.json_steps import STEP, decode
from service.jobs.json_text import Encoded, decode_parts
from service.jobs.outcome import Crashed, Outcome, Returned, TimedOut, error_of
from service.jobs.queue import CallKind
from service.jobs.scheduler import Scheduler
from service.jobs.worker.assignment import Assignment, Worker

_ATTEMPTS = 2


@dataclass(frozen=True)
class Question:
    """What a short task is asked.

    Attributes:
        task: `module:function`.
        payload: What it is called with.
        queue: Which workers may run it.
        time_limit: For the work [s]; what it waits for a slot does not count.
        worker_timeout: How long it waits for a slot [s].
        world_digest: Workers that have this scene loaded are preferred.
        size: How much is asked: lists with twice as many items take longer.
        digest_field: Of a task that loads a scene, the field of its answer that is the warm key of it.
        is_raw: Whether the answer is wanted as the JSON that the task gave.
        is_partly_raw: Whether the members that the task encoded itself are wanted as they are.
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

    @property
    def kind(self) -> CallKind:
        """What it has in common with questions that take about as long."""
        return CallKind(self.task, self.size.bit_length(), is_load=bool(self.digest_field))


@dataclass(frozen=True)
class Answer:
    """What a short task returned.

    Attributes:
        content: Decoded JSON, or `Encoded` if it is passed on, or an object of both.
        waited: For a slot [s].
        worked: In the slot [s].
    """

    content: Any
    waited: float
    worked: float


@dataclass(frozen=True)
class _Done:
    outcome: Outcome
    content: Any
    seconds: float


class Calls:
    """Asks the slots of a floor."""

    def __init__(self, scheduler: Scheduler) -> None:
        """Ask `floor`."""
        self._scheduler = scheduler
        self._num_calls = 0

    async def ask(self, question: Question) -> Answer:
        """Return the answer; canceled, the task is told to end, and made to a little later.

        Raises:
            WayproofError: What the task raised.
            QueueFull: As many wait as may.
            QueueTimeout: No slot was free in time.
            DeadlineExceeded: The task took too long.
            WorkerCrashed: Its process died, twice.
        """
        self._scheduler.check_room(question.queue)
        loop = asyncio.get_running_loop()
        waited = 0.0
        for attempt in range(1, _ATTEMPTS + 1):
            came = loop.time()
            slot = await self._worker_for(question)
            waited += loop.time() - came
            done = await self._shielded_run(question, slot)
            outcome = done.outcome
            if isinstance(outcome, Returned):
                return Answer(done.content, waited, done.seconds)
            if isinstance(outcome, TimedOut):
                message = f"no answer within {question.time_limit:g} s"
                evidence = {"allowed": question.time_limit, "during": WORKER, "waited": waited}
                raise DeadlineExceeded(message, evidence).in_stage(WORKER)
            if not isinstance(outcome, Crashed) or attempt == _ATTEMPTS:
                raise error_of(outcome, attempt)
        raise AssertionError

    async def _worker_for(self, question: Question) -> Worker:
        """Return a slot as soon as there is one.

        Raises:
            QueueTimeout: There was none in time.
        """
        seated: asyncio.Future[Worker] = asyncio.get_running_loop().create_future()
        self._num_calls += 1
        ticket = f"call {self._num_calls}"
        use = partial(self._assign, question.queue, seated)
        asked = (question.world_digest, question.kind)
        self._scheduler.request_for_call(question.queue, ticket, use, *asked)
        try:
            async with asyncio.timeout(question.worker_timeout):
                return await seated
        except (TimeoutError, asyncio.CancelledError) as ended:
            self._scheduler.queue(question.queue).remove(ticket)
            if seated.done() and not seated.cancelled():
                self._scheduler.return_worker(question.queue, seated.result())
            if isinstance(ended, TimeoutError):
                raise self._timeout_error(question) from ended
            raise

    async def _shielded_run(self, question: Question, slot: Worker) -> "_Done":
        """Run the task; if it is not waited for any more, it ends, and the slot is free again."""
        work = asyncio.get_running_loop().create_task(self._run(question, slot))
        self._scheduler.keep(work)
        try:
            return await asyncio.shield(work)
        except asyncio.CancelledError:
            slot.cancel(self._scheduler.queue(question.queue).cancel_grace)
            raise

    async def _run(self, question: Question, slot: Worker) -> "_Done":
        loop = asyncio.get_running_loop()
        began = loop.time()
        run = Assignment(question.task, question.payload, NullSink(), question.time_limit)
        content: Any = None
        try:
            outcome = await slot.run(run)
            if isinstance(outcome, Returned):
                content = await self._content(question, outcome.result)
            return _Done(outcome, content, loop.time() - began)
        finally:
            seconds = loop.time() - began
            if question.digest_field and content is not None:
                lane, key = self._scheduler.queue(question.queue), content[question.digest_field]
                lane.pool.warm(slot, key)
                lane.durations.record_load(key, seconds)
            self._scheduler.release(question.queue, slot, seconds)

    @staticmethod
    async def _content(question: Question, result: Encoded) -> Any:
        if question.is_raw:
            return result
        read = decode_parts if question.is_partly_raw else decode
        if len(result.text) <= STEP:
            return read(result.text)
        # What is large is decoded elsewhere: nothing else would be answered meanwhile.
        return await asyncio.to_thread(read, result.text)

    def _assign(self, lane: str, seated: asyncio.Future[Worker], slot: Worker) -> None:
        """Hand a slot to a call; take it back if the call waits no longer."""
        if seated.done():
            self._scheduler.return_worker(lane, slot)
        else:
            seated.set_result(slot)

    def _timeout_error(self, question: Question) -> QueueTimeout:
        lane = self._scheduler.queue(question.queue)
        message = f"no worker was free within {question.worker_timeout:g} s; try again later"
        evidence = {
            "lane": lane.name,
            "waited": question.worker_timeout,
            "queued": lane.num_waiting,
            "retry_after": lane.retry_after,
        }
        return QueueTimeout(message, evidence)
