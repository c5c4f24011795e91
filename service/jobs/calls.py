"""Calls: questions that are answered by slots and need no record."""

import asyncio
from dataclasses import dataclass
from functools import partial
from typing import Any

from planning.errors import DeadlineExceeded
from service.jobs.durations import Kind
from service.jobs.errors import WORKER, QueueTimeout
from service.jobs.floor import Floor
from service.jobs.json_steps import STEP, decode
from service.jobs.json_text import Encoded, decode_parts
from service.jobs.outcome import Crashed, Outcome, Returned, TimedOut, error_of
from service.jobs.recorder import NoSink
from service.jobs.slot import Run, Slot

_ATTEMPTS = 2


@dataclass(frozen=True)
class Question:
    """What a short task is asked.

    Attributes:
        task: `module:function`.
        payload: What it is called with.
        lane: Which slots may run it.
        allowed: For the work [s]; what it waits for a slot does not count.
        patience: How long it waits for a slot [s].
        warm_key: Slots that have this scene loaded are preferred.
        size: How much is asked: lists with twice as many items take longer.
        leaves: Of a task that loads a scene, the field of its answer that is the warm key of it.
        is_passed_on: Whether the answer is wanted as the JSON that the task gave.
        is_in_parts: Whether the members that the task encoded itself are wanted as they are.
    """

    task: str
    payload: dict[str, Any]
    lane: str
    allowed: float
    patience: float
    warm_key: str | None = None
    size: int = 0
    leaves: str = ""
    is_passed_on: bool = False
    is_in_parts: bool = False

    @property
    def kind(self) -> Kind:
        """What it has in common with questions that take about as long."""
        return Kind(self.task, self.size.bit_length(), is_load=bool(self.leaves))


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

    def __init__(self, floor: Floor) -> None:
        """Ask `floor`."""
        self._floor = floor
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
        self._floor.require_room(question.lane)
        loop = asyncio.get_running_loop()
        waited = 0.0
        for attempt in range(1, _ATTEMPTS + 1):
            came = loop.time()
            slot = await self._seated(question)
            waited += loop.time() - came
            done = await self._answered(question, slot)
            outcome = done.outcome
            if isinstance(outcome, Returned):
                return Answer(done.content, waited, done.seconds)
            if isinstance(outcome, TimedOut):
                message = f"no answer within {question.allowed:g} s"
                evidence = {"allowed": question.allowed, "during": WORKER, "waited": waited}
                raise DeadlineExceeded(message, evidence).in_stage(WORKER)
            if not isinstance(outcome, Crashed) or attempt == _ATTEMPTS:
                raise error_of(outcome, attempt)
        raise AssertionError

    async def _seated(self, question: Question) -> Slot:
        """Return a slot as soon as there is one.

        Raises:
            QueueTimeout: There was none in time.
        """
        seated: asyncio.Future[Slot] = asyncio.get_running_loop().create_future()
        self._num_calls += 1
        ticket = f"call {self._num_calls}"
        use = partial(self._sit, question.lane, seated)
        asked = (question.warm_key, question.kind)
        self._floor.seat_question(question.lane, ticket, use, *asked)
        try:
            async with asyncio.timeout(question.patience):
                return await seated
        except (TimeoutError, asyncio.CancelledError) as ended:
            self._floor.lane(question.lane).remove(ticket)
            if seated.done() and not seated.cancelled():
                self._floor.readmit(question.lane, seated.result())
            if isinstance(ended, TimeoutError):
                raise self._too_late(question) from ended
            raise

    async def _answered(self, question: Question, slot: Slot) -> "_Done":
        """Run the task; if it is not waited for any more, it ends, and the slot is free again."""
        work = asyncio.get_running_loop().create_task(self._run(question, slot))
        self._floor.keep(work)
        try:
            return await asyncio.shield(work)
        except asyncio.CancelledError:
            slot.cancel(self._floor.lane(question.lane).cancel_grace)
            raise

    async def _run(self, question: Question, slot: Slot) -> "_Done":
        loop = asyncio.get_running_loop()
        began = loop.time()
        run = Run(question.task, question.payload, NoSink(), question.allowed)
        content: Any = None
        try:
            outcome = await slot.run(run)
            if isinstance(outcome, Returned):
                content = await self._content(question, outcome.result)
            return _Done(outcome, content, loop.time() - began)
        finally:
            seconds = loop.time() - began
            if question.leaves and content is not None:
                lane, key = self._floor.lane(question.lane), content[question.leaves]
                lane.pool.warm(slot, key)
                lane.durations.note_load(key, seconds)
            self._floor.release(question.lane, slot, seconds)

    @staticmethod
    async def _content(question: Question, result: Encoded) -> Any:
        if question.is_passed_on:
            return result
        read = decode_parts if question.is_in_parts else decode
        if len(result.text) <= STEP:
            return read(result.text)
        # What is large is decoded elsewhere: nothing else would be answered meanwhile.
        return await asyncio.to_thread(read, result.text)

    def _sit(self, lane: str, seated: asyncio.Future[Slot], slot: Slot) -> None:
        """Hand a slot to a call; take it back if the call waits no longer."""
        if seated.done():
            self._floor.readmit(lane, slot)
        else:
            seated.set_result(slot)

    def _too_late(self, question: Question) -> QueueTimeout:
        lane = self._floor.lane(question.lane)
        message = f"no worker was free within {question.patience:g} s; try again later"
        evidence = {
            "lane": lane.name,
            "waited": question.patience,
            "queued": lane.num_waiting,
            "retry_after": lane.retry_after,
        }
        return QueueTimeout(message, evidence)
