"""Slot: one warm process that runs one task at a time and can be ended at any moment."""

import asyncio
import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from service.jobs.error_text import error_in
from service.jobs.json_text import Encoded
from service.jobs.link import Frame, FrameKind, two_parts
from service.jobs.memory import MemoryWatch, resident
from service.jobs.outcome import Crashed, Ended, Outcome, Overgrown, Raised, Returned, returned
from service.jobs.stop import Stop
from service.jobs.worker import Terms
from service.jobs.worker_process import WorkerProcess, forkserver

_FIRST_PAUSE, _LONGEST_PAUSE = 0.05, 5.0
_log = logging.getLogger(__name__)


class EventSink(Protocol):
    """Where the events of a run go."""

    def put(self, event_type: str, data: Encoded, *, is_update: bool = False) -> None:
        """Take an event; an update may replace the one of its type before it."""
        ...

    async def room(self) -> None:
        """Wait while too many events have been taken and not been dealt with."""
        ...


@dataclass(frozen=True)
class Run:
    """One run of a task.

    Attributes:
        task: `module:function`.
        payload: What it is called with.
        sink: Told of each of its events, in the event loop's thread.
        allowed: Seconds after which it is told to end, and a little later made to; or None. A task
            that knows better may change them while it runs.
        controls: What is asked of it when it begins; `Slot.control` tells what is asked later.
    """

    task: str
    payload: dict[str, Any]
    sink: EventSink
    allowed: float | None = None
    controls: Mapping[str, Any] = field(default_factory=dict)


class Slot(Protocol):
    """Where tasks run, one at a time."""

    @property
    def generation(self) -> int:
        """A number that changes with the process: another one has no scene loaded."""
        ...

    @property
    def fault(self) -> str | None:
        """Why no run would begin at once, or would not end well; None if all is well."""
        ...

    async def open(self, warm_up: str | None) -> None:
        """Begin to get ready; every process of the slot runs the task `warm_up` first."""
        ...

    async def ready(self) -> None:
        """Wait until a run would begin at once."""
        ...

    async def run(self, run: Run) -> Outcome:
        """Run a task to its end, whatever that is."""
        ...

    def cancel(self, grace: float) -> None:
        """Ask the present run to end; end it by force after `grace` seconds."""
        ...

    def control(self, controls: Mapping[str, Any]) -> None:
        """Tell the present run all that is asked of it by now."""
        ...

    async def close(self) -> None:
        """End the slot and what runs in it."""
        ...


class ProcessSlot:
    """A slot that is a process of its own, forked off a server that has imported what it needs.

    The process is replaced as soon as it has ended, also while it had nothing to do.
    """

    def __init__(self, preload: Sequence[str], terms: Terms | None = None) -> None:
        """Prepare; `open` starts the process.

        Args:
            preload: Modules that the forkserver imports once, so that new processes have them.
            terms: On which the process works.
        """
        self.generation = 0
        self._preload = preload
        self._terms = terms or Terms()
        self._warm_up_fault: str | None = None
        self._worker: WorkerProcess | None = None
        self._is_ready = asyncio.Event()
        self._keeper: asyncio.Task[None] | None = None
        self._token = 0
        self._stop: Stop | None = None
        self._speaking_to: WorkerProcess | None = None

    @property
    def fault(self) -> str | None:
        """Why no run would begin at once, or would not end well."""
        return self._warm_up_fault if self._is_ready.is_set() else "no process is ready"

    async def open(self, warm_up: str | None) -> None:
        """Begin to get ready."""
        self._keeper = asyncio.get_running_loop().create_task(self._keep(warm_up))

    async def ready(self) -> None:
        """Wait for a warm process."""
        await self._is_ready.wait()

    async def run(self, run: Run) -> Outcome:
        """Run a task to its end."""
        stop = self._stop = Stop(run.allowed)
        try:
            await self._is_ready.wait()
            return Ended() if stop.is_canceled else await self._converse(run, stop)
        finally:
            stop.disarm()
            self._stop = None

    def cancel(self, grace: float) -> None:
        """Tell the task, and end its process if it has not ended by itself in time."""
        if self._stop is not None:
            self._stop.cancel(grace)

    def control(self, controls: Mapping[str, Any]) -> None:
        """Tell the task; one that has not begun is told when it does."""
        if self._speaking_to is not None:
            body = json.dumps(controls).encode()
            self._speaking_to.send(Frame(FrameKind.CONTROLS, self._token, body))

    async def close(self) -> None:
        """End the process, whatever it does."""
        if self._keeper is not None:
            self._keeper.cancel()
            await asyncio.gather(self._keeper, return_exceptions=True)

    async def _converse(self, run: Run, stop: Stop) -> Outcome:
        """Send the task and deal with what the process says until it has ended."""
        worker = self._worker
        assert worker is not None  # noqa: S101  (that is what ready means)
        self._token += 1
        cancel = Frame(FrameKind.CANCEL, self._token)
        stop.begin(lambda: worker.send(cancel), lambda: self._kill(worker))
        body = two_parts(run.task, json.dumps(run.payload))
        worker.send(Frame(FrameKind.TASK, self._token, body))
        self._speaking_to = worker
        if run.controls:
            self.control(run.controls)
        bound = self._terms.memory
        watch = MemoryWatch(worker.pid, bound, lambda: stop.cancel(self._terms.memory_grace))
        try:
            outcome = await self._listen(worker, run, stop)
        except (ValueError, KeyError, TypeError):
            self._kill(worker)
            outcome = stop.verdict(Crashed(await worker.end(), "it spoke nonsense"))
        except BaseException:
            self._kill(worker)
            raise
        finally:
            watch.end()
            self._speaking_to = None
        return outcome if bound is None else self._within(bound, watch, outcome, worker)

    def _within(
        self, bound: int, watch: MemoryWatch, outcome: Outcome, worker: WorkerProcess
    ) -> Outcome:
        """Return what an outcome means where memory has a bound [bytes]."""
        if resident(worker.pid) > bound / 2:  # what it keeps must not be held against the next
            self._kill(worker)
        is_refused = isinstance(outcome, Crashed) and outcome.reason == "MemoryError"
        if is_refused or (watch.is_exceeded and not isinstance(outcome, Returned)):
            return Overgrown(watch.used, bound)
        return outcome

    async def _listen(self, worker: WorkerProcess, run: Run, stop: Stop) -> Outcome:
        reason = ""
        while (frame := await worker.receive()) is not None:
            stop.heard()
            match frame.kind:
                case FrameKind.EVENT | FrameKind.UPDATE | FrameKind.TERM | FrameKind.WATCH:
                    await _take_in(frame, run.sink, stop)
                case FrameKind.RESULT:
                    return returned(*frame.parts)
                case FrameKind.FAILURE:
                    return stop.verdict(Raised(error_in(frame.body.decode())))
                case FrameKind.CRASH:
                    reason = frame.body.decode()
                case _:
                    self._kill(worker)
                    reason = f"it spoke out of turn: {frame.kind.name}"
        self._is_ready.clear()
        return stop.verdict(Crashed(await worker.end(), reason))

    def _kill(self, worker: WorkerProcess) -> None:
        """End a process; nothing is to be run in it any more."""
        if worker is self._worker:
            self._is_ready.clear()
        worker.kill()

    async def _keep(self, warm_up: str | None) -> None:
        """Have a process, always."""
        context = forkserver(self._preload)
        pause = _FIRST_PAUSE
        while True:
            worker = await self._hatch(context, warm_up)
            if worker is None:
                await asyncio.sleep(pause)
                pause = min(2 * pause, _LONGEST_PAUSE)
                continue
            pause = _FIRST_PAUSE
            self._worker = worker
            self.generation += 1
            self._is_ready.set()
            try:
                await worker.ended.wait()
            finally:
                self._is_ready.clear()
                worker.kill()
                await asyncio.shield(worker.end())

    async def _hatch(self, context: Any, warm_up: str | None) -> WorkerProcess | None:
        """Return a new process that is ready, None if that did not work."""
        try:
            worker = await WorkerProcess.start(context, warm_up, self._terms)
        except (OSError, EOFError):
            _log.exception("a worker process could not be started")
            return None
        try:
            frame = await worker.receive()
        except asyncio.CancelledError:
            worker.kill()
            await asyncio.shield(worker.end())
            raise
        if frame is None or frame.kind is not FrameKind.READY:
            code = await worker.end()
            _log.error("a worker process died before it was ready, with exit code %s", code)
            return None
        self._warm_up_fault = frame.body.decode()[:2000] or None
        if self._warm_up_fault is not None:
            _log.warning("the warm-up %s failed: %s", warm_up, self._warm_up_fault)
        return worker


async def _take_in(frame: Frame, sink: EventSink, stop: Stop) -> None:
    """Deal with what a task says on its way."""
    match frame.kind:
        case FrameKind.TERM:
            stop.allow(float(frame.body))
        case FrameKind.WATCH:
            stop.watch(float(frame.body))
        case kind:
            event_type, data = frame.parts
            is_update = kind is FrameKind.UPDATE
            sink.put(event_type, Encoded(data), is_update=is_update)
            if not is_update:
                await sink.room()
