"""ProcessWorker: one warm process that runs one task at a time, and can be killed at any moment."""

import asyncio
import json
import logging
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from service.jobs.artifacts import ArtifactCopies
from service.jobs.json_text import Encoded
from service.jobs.outcome import (
    Crashed,
    MemoryExceeded,
    Outcome,
    Raised,
    Returned,
    Terminated,
    returned,
)
from service.jobs.worker.assignment import Assignment, EventSink
from service.jobs.worker.forkserver import forkserver, forkserver_pid
from service.jobs.worker.main import Terms
from service.jobs.worker.memory import MemoryWatch, resident
from service.jobs.worker.process import LONGEST_START, WorkerProcess, leave_forkserver
from service.jobs.worker.protocol import Message, MessageKind, load_error, two_parts
from service.jobs.worker.termination import Termination

_FIRST_PAUSE, _LONGEST_PAUSE = 0.05, 5.0
# Processes that die in a row before they are ready, after which their forkserver is replaced.
_MOST_STILLBORN = 3
# What a task sends before it ends.
_ON_THE_WAY = (MessageKind.EVENT, MessageKind.UPDATE, MessageKind.DEADLINE, MessageKind.WATCH)
_log = logging.getLogger(__name__)


class ProcessWorker:
    """A worker that is a process of its own, forked off a server that has imported what it needs.

    The process is replaced as soon as it has ended, also while it had nothing to do.
    """

    is_lost = False

    def __init__(
        self,
        preload: Sequence[str],
        terms: Terms | None = None,
        copies: ArtifactCopies | None = None,
    ) -> None:
        """Prepare; `open` starts the process.

        Args:
            preload: Modules that the forkserver imports once, so that new processes have them.
            terms: On which the process works.
            copies: Of artifacts on this host; None if its tasks read none.
        """
        self.generation = 0
        self._preload = preload
        self._copies = copies
        self._folder = None if copies is None else copies.folder
        self._terms = terms or Terms()
        self._warm_up_fault: str | None = None
        self._process: WorkerProcess | None = None
        self._is_ready = asyncio.Event()
        self._supervisor: asyncio.Task[None] | None = None
        self._token = 0
        self._has_run = False
        self._termination: Termination | None = None
        self._running_in: WorkerProcess | None = None

    @property
    def fault(self) -> str | None:
        """Why no run would begin at once, or would not end well."""
        return self._warm_up_fault if self._is_ready.is_set() else "no process is there"

    async def open(self, warm_up: str | None) -> None:
        """Begin to get ready."""
        self._supervisor = asyncio.get_running_loop().create_task(self._supervise(warm_up))

    async def ready(self) -> None:
        """Wait for a warm process; one that keeps too much of what it ran is replaced."""
        process, bound = self._process, self._terms.memory
        # Not when a run ends: a client waits for that.
        if self._has_run and process is not None and bound is not None:
            self._has_run = False
            if resident(process.pid) > bound / 2:  # it must not be held against the next
                self._kill(process)
        await self._is_ready.wait()

    async def bring(self, artifacts: Sequence[str]) -> None:
        """Copy what this host lacks of some artifacts."""
        if self._copies is not None:
            await self._copies.bring(artifacts)

    async def run(self, run: Assignment) -> Outcome:
        """Run a task to its end."""
        termination = self._termination = Termination(run.time_limit)
        try:
            await self.ready()
            is_canceled = termination.is_canceled
            return Terminated() if is_canceled else await self._run(run, termination)
        finally:
            termination.disarm()
            self._termination = None

    def cancel(self, grace: float) -> None:
        """Tell the task, and end its process if it has not ended by itself in time."""
        if self._termination is not None:
            self._termination.cancel(grace)

    def control(self, controls: Mapping[str, Any]) -> None:
        """Tell the task; one that has not begun is told when it does."""
        if self._running_in is not None:
            body = json.dumps(controls).encode()
            self._running_in.send(Message(MessageKind.CONTROLS, self._token, body))

    async def close(self) -> None:
        """End the process, whatever it does."""
        if self._supervisor is not None:
            self._supervisor.cancel()
            await asyncio.gather(self._supervisor, return_exceptions=True)

    async def _run(self, run: Assignment, termination: Termination) -> Outcome:
        """Send the task and deal with what the process says until it has ended."""
        process = self._process
        assert process is not None  # noqa: S101  (that is what ready means)
        self._token += 1
        cancel = Message(MessageKind.CANCEL, self._token)
        termination.begin(lambda: process.send(cancel), lambda: self._kill(process))
        body = two_parts(json.dumps([run.task, dict(run.ids)]), run.payload.text)
        process.send(Message(MessageKind.TASK, self._token, body))
        self._running_in = process
        if run.controls:
            self.control(run.controls)
        bound = self._terms.memory
        grace = self._terms.memory_grace
        watch = MemoryWatch(process.pid, bound, lambda: termination.cancel(grace))
        try:
            outcome = await self._read_messages(process, run, termination)
        except (ValueError, KeyError, TypeError):
            self._kill(process)
            outcome = termination.classify(Crashed(await process.end(), "it spoke nonsense"))
        except BaseException:
            self._kill(process)
            raise
        finally:
            watch.end()
            self._running_in, self._has_run = None, True
        return outcome if bound is None else _within(bound, watch, outcome)

    async def _read_messages(
        self, process: WorkerProcess, run: Assignment, termination: Termination
    ) -> Outcome:
        reason = ""
        while (message := await process.receive()) is not None:
            termination.heard()
            match message.kind:
                case kind if kind in _ON_THE_WAY:
                    await _apply(message, run.sink, termination)
                case MessageKind.RESULT:
                    return returned(*message.parts)
                case MessageKind.FAILURE:
                    return termination.classify(Raised(load_error(message.body.decode())))
                case MessageKind.CRASH:
                    reason = message.body.decode()
                case _:
                    self._kill(process)
                    reason = f"it spoke out of turn: {message.kind.name}"
        self._is_ready.clear()
        return termination.classify(Crashed(await process.end(), reason))

    def _kill(self, process: WorkerProcess) -> None:
        """End a process; nothing is to be run in it any more."""
        if process is self._process:
            self._is_ready.clear()
        process.kill()

    async def _supervise(self, warm_up: str | None) -> None:
        """Have a process, always."""
        context = forkserver(self._preload)
        pause, num_stillborn = _FIRST_PAUSE, 0
        while True:
            forked_off = forkserver_pid()  # or a newer one
            process = await self._spawn(context, warm_up)
            if process is None:
                num_stillborn += 1
                if num_stillborn % _MOST_STILLBORN == 0:
                    await _leave_forkserver(forked_off, num_stillborn)
                await asyncio.sleep(pause)
                pause = min(2 * pause, _LONGEST_PAUSE)
                continue
            pause, num_stillborn = _FIRST_PAUSE, 0
            self._process = process
            self.generation += 1
            self._is_ready.set()
            try:
                await process.ended.wait()
            finally:
                self._is_ready.clear()
                process.kill()
                await asyncio.shield(process.end())

    async def _spawn(self, context: Any, warm_up: str | None) -> WorkerProcess | None:
        """Return a new process that is ready, None if that did not work."""
        try:
            process = await WorkerProcess.start(context, self._folder, warm_up, self._terms)
        except (OSError, EOFError):
            _log.exception("a worker process could not be started")
            return None
        try:
            async with asyncio.timeout(LONGEST_START):
                message = await process.receive()
        except TimeoutError:  # native code that does not return, and no run whose time ends it
            _log.error("a worker process was not ready within %g s, and is ended", LONGEST_START)
            process.kill()
            message = None
        except asyncio.CancelledError:
            process.kill()
            await asyncio.shield(process.end())
            raise
        if message is None or message.kind is not MessageKind.READY:
            code = await process.end()
            _log.error("a worker process died before it was ready, with exit code %s", code)
            return None
        network, fault = message.parts
        if network:
            _tell_of_network(network)
        self._warm_up_fault = fault[:2000] or None
        if self._warm_up_fault is not None:
            _log.warning("the warm-up %s failed: %s", warm_up, self._warm_up_fault)
        return process


async def _leave_forkserver(pid: int | None, num_stillborn: int) -> None:
    told = "%d worker processes in a row died before they were ready: the forkserver %s is replaced"
    _log.error(told, num_stillborn, pid)
    await leave_forkserver(pid)


def _within(bound: int, watch: MemoryWatch, outcome: Outcome) -> Outcome:
    """Return what an outcome means where memory has a bound [bytes]."""
    is_refused = isinstance(outcome, Crashed) and outcome.reason == "MemoryError"
    if is_refused or (watch.is_exceeded and not isinstance(outcome, Returned)):
        return MemoryExceeded(watch.used, bound)
    return outcome


@cache
def _tell_of_network(reason: str) -> None:
    """Say once why workers are not kept from the network, though they should be."""
    _log.warning("workers can reach the network (%s): see docs/explanation/security.md", reason)


async def _apply(message: Message, sink: EventSink, termination: Termination) -> None:
    """Deal with what a task says on its way."""
    match message.kind:
        case MessageKind.DEADLINE:
            termination.set_deadline(*map(float, json.loads(message.body)))
        case MessageKind.WATCH:
            termination.limit_silence(float(message.body))
        case kind:
            event_type, data = message.parts
            is_update = kind is MessageKind.UPDATE
            sink.put(event_type, Encoded(data), is_update=is_update)
            if not is_update:
                await sink.wait_for_space()
