"""ThreadWorker: tasks in a thread of this process, for tests that want no processes.

Nothing can be forced here: a task that does not heed a cancel or its deadline keeps its thread,
and a crash of native code ends everything. A run is given up in time all the same.
"""

import asyncio
import threading
from collections.abc import Mapping, Sequence
from contextlib import nullcontext, suppress
from typing import Any

from service.jobs.artifacts import ArtifactCopies
from service.jobs.host_folder import set_host_folder
from service.jobs.json_text import Encoded, encode_leniently
from service.jobs.outcome import Crashed, Outcome, Raised, Terminated, returned
from service.jobs.worker.assignment import Assignment, EventSink
from service.jobs.worker.protocol import MessageKind, load_error
from service.jobs.worker.run_task import TaskEnd, event_text, run_task
from service.jobs.worker.termination import Termination
from service.telemetry.ids import with_ids

# Drake worlds are kept per process and OMPL's random numbers are global to it: one task at a time.
_ONE_AT_A_TIME = threading.Lock()
_GIVEN_UP = TaskEnd(MessageKind.CRASH, "it does not end")


class _ThreadContext:
    """A task's events, limits and controls within the process."""

    def __init__(
        self, loop: asyncio.AbstractEventLoop, run: Assignment, termination: Termination
    ) -> None:
        self._loop = loop
        self._sink: EventSink = run.sink
        self._termination = termination
        self.canceled = threading.Event()
        # Replaced whole, so that the thread sees either all or none of the controls.
        self.controls_set: dict[str, Any] = dict(run.controls)

    def emit(self, event_type: str, data: dict[str, Any]) -> None:
        """Hand an event to the loop."""
        self._put(event_type, event_text(data), is_update=False)

    def emit_whole(self, event_type: str, data: dict[str, Any]) -> None:
        """Hand an event to the loop, however long it is."""
        self._put(event_type, encode_leniently(data), is_update=False)

    def update(self, event_type: str, data: dict[str, Any]) -> None:
        """Hand an event that the next of its type may replace to the loop."""
        self._put(event_type, event_text(data), is_update=True)

    def watch(self, silence: float) -> None:
        """Have this run given up if it says nothing for so long, from now on."""
        self._loop.call_soon_threadsafe(self._termination.limit_silence, silence)

    def controls(self) -> dict[str, Any]:
        """Return all controls that were set for this run."""
        return self.controls_set

    def allow(self, seconds: float, grace: float = 0.0) -> None:
        """Have this run given up after some seconds from now on, and not before."""
        self._loop.call_soon_threadsafe(self._termination.set_deadline, seconds, grace)

    def is_canceled(self) -> bool:
        """Return whether the end of this run was requested."""
        return self.canceled.is_set()

    def _put(self, event_type: str, text: str, *, is_update: bool) -> None:
        encoded = Encoded(text)

        def take() -> None:
            self._termination.heard()
            self._sink.put(event_type, encoded, is_update=is_update)

        self._loop.call_soon_threadsafe(take)


class ThreadWorker:
    """A worker that is a thread."""

    is_lost = False

    def __init__(self, copies: ArtifactCopies | None = None, *, is_exclusive: bool) -> None:
        """Prepare.

        Args:
            copies: Of artifacts on this host; None if its tasks read none.
            is_exclusive: Whether its tasks and those of other exclusive workers take turns.
        """
        self.generation = 0
        self.fault: str | None = None
        self._copies = copies
        self._is_exclusive = is_exclusive
        self._is_free = asyncio.Event()
        self._is_free.set()
        self._termination: Termination | None = None
        self._context: _ThreadContext | None = None

    async def open(self, warm_up: str | None) -> None:
        """Do nothing: this process is as warm as it is."""

    async def ready(self) -> None:
        """Wait until a thread that was given up has ended."""
        await self._is_free.wait()

    async def bring(self, artifacts: Sequence[str]) -> None:
        """Copy what this host lacks of some artifacts."""
        if self._copies is not None:
            await self._copies.bring(artifacts)

    async def run(self, run: Assignment) -> Outcome:
        """Run a task to its end, or until it is given up."""
        termination = self._termination = Termination(run.time_limit)
        try:
            await self._is_free.wait()
            return Terminated() if termination.is_canceled else await self._run(run, termination)
        finally:
            termination.disarm()
            self._termination = self._context = None

    def cancel(self, grace: float) -> None:
        """Tell the task, and give it up if it has not ended in time."""
        if self._termination is not None:
            self._termination.cancel(grace)

    def control(self, controls: Mapping[str, Any]) -> None:
        """Tell the task; one that has not begun is told when it does."""
        if self._context is not None:
            self._context.controls_set = dict(controls)

    async def close(self) -> None:
        """Tell the present task to end; its thread does not keep this process alive."""
        self.cancel(0.0)

    async def _run(self, run: Assignment, termination: Termination) -> Outcome:
        loop = asyncio.get_running_loop()
        context = self._context = _ThreadContext(loop, run, termination)
        done: asyncio.Future[TaskEnd] = loop.create_future()
        termination.begin(context.canceled.set, lambda: _settle(done, _GIVEN_UP))
        self._is_free.clear()
        work = (loop, run, context, done)
        threading.Thread(target=self._work, args=work, name="thread-worker", daemon=True).start()
        try:
            end = await done
        except asyncio.CancelledError:
            context.canceled.set()
            raise
        match end.kind:
            case MessageKind.RESULT:
                return returned(end.summary, end.text)
            case MessageKind.FAILURE:
                return termination.classify(Raised(load_error(end.text)))
            case _:
                return termination.classify(Crashed(None, end.text))

    def _work(
        self,
        loop: asyncio.AbstractEventLoop,
        run: Assignment,
        context: _ThreadContext,
        done: asyncio.Future[TaskEnd],
    ) -> None:
        """Run the task, in the thread."""
        if self._copies is not None:
            set_host_folder(self._copies.folder)
        with with_ids(run.ids), _ONE_AT_A_TIME if self._is_exclusive else nullcontext():
            end = run_task(run.task, run.payload.text, context)

        def finish() -> None:
            self._is_free.set()
            _settle(done, end)

        with suppress(RuntimeError):  # the loop is closed
            loop.call_soon_threadsafe(finish)


def _settle(future: asyncio.Future[TaskEnd], end: TaskEnd) -> None:
    if not future.done():
        future.set_result(end)
