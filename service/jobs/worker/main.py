"""What runs in a slot's process. Light: the forkserver imports it before any task."""

import gc
import json
import os
import socket
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from service.jobs.task import TaskEnd, event_text, run_task
from service.jobs.worker.memory import limit_own
from service.jobs.worker.parent_watch import exit_with_parent
from service.jobs.worker.protocol import Message, MessageKind, MessagePipe, two_parts

_CRASH_CODE = 70


class PipeContext:
    """The task's end of its slot."""

    def __init__(self, link: MessagePipe, token: int) -> None:
        """Speak for the run that `token` numbers."""
        self._link = link
        self._token = token
        self._is_canceled = False
        self._controls: dict[str, Any] = {}

    def emit(self, event_type: str, data: dict[str, Any]) -> None:
        """Send an event; waits if the server does not keep up."""
        self._tell(MessageKind.EVENT, two_parts(event_type, event_text(data)))

    def update(self, event_type: str, data: dict[str, Any]) -> None:
        """Send an event that the next of its type may replace."""
        self._tell(MessageKind.UPDATE, two_parts(event_type, event_text(data)))

    def allow(self, seconds: float) -> None:
        """Have this run ended after so many seconds from now on, and not before."""
        self._tell(MessageKind.DEADLINE, repr(seconds).encode())

    def watch(self, silence: float) -> None:
        """Have this process ended if it says nothing for so long, from now on."""
        self._tell(MessageKind.WATCH, repr(silence).encode())

    def controls(self) -> dict[str, Any]:
        """Return all that was asked of this run."""
        self._listen()
        return self._controls

    def is_canceled(self) -> bool:
        """Return whether the end of this run was asked for."""
        self._listen()
        return self._is_canceled

    def _tell(self, kind: MessageKind, body: bytes) -> None:
        self._link.send(Message(kind, self._token, body))

    def _listen(self) -> None:
        """Take in what has come; a run that is to end is told no more."""
        while not self._is_canceled and self._link.has_news:
            frame = self._link.receive()
            if frame is None:  # without the server the answer has no use
                self._is_canceled = True
            elif frame.token == self._token:  # what an earlier run was told is stale
                self._take_in(frame)

    def _take_in(self, frame: Message) -> None:
        if frame.kind is MessageKind.CONTROLS:
            self._controls = json.loads(frame.body)
        else:
            self._is_canceled = True


class _WarmUpContext:
    """For the warm-up, which nobody listens to."""

    def emit(self, event_type: str, data: dict[str, Any]) -> None:
        """Drop an event."""

    def update(self, event_type: str, data: dict[str, Any]) -> None:
        """Drop an event."""

    def allow(self, seconds: float) -> None:
        """Do nothing: a warm-up has no limit."""

    def watch(self, silence: float) -> None:
        """Do nothing: a warm-up may be silent."""

    def controls(self) -> dict[str, Any]:
        """Return that nothing is asked."""
        return {}

    def is_canceled(self) -> bool:
        """Return that nobody does."""
        return False


@dataclass(frozen=True)
class Terms:
    """On what terms a process works.

    Attributes:
        niceness: How far it lets others go before (nice(2)), 0 to 19.
        memory: What it may use [bytes]; None for all that there is.
        memory_grace: How long a task may take to end by itself once it uses more [s].
    """

    niceness: int = 0
    memory: int | None = None
    memory_grace: float = 0.0


def serve(end: socket.socket, parent: Connection, warm_up: str | None, terms: Terms) -> None:
    """Run tasks one after the other until the other end is gone.

    Args:
        end: To the slot.
        parent: When its other end closes, this process ends at once.
        warm_up: A task to run first, with an empty payload.
        terms: Of the work.
    """
    exit_with_parent(parent)
    gc.freeze()
    gc.enable()
    os.nice(terms.niceness)
    if terms.memory is not None:
        limit_own(terms.memory)
    link = MessagePipe(end)
    fault = b""
    if warm_up is not None:
        warmed = run_task(warm_up, "{}", _WarmUpContext())
        if warmed.kind is not MessageKind.RESULT:
            fault = warmed.text.encode()
    link.send(Message(MessageKind.READY, 0, fault))
    while (frame := link.receive()) is not None:
        if frame.kind is MessageKind.TASK:
            task, payload = frame.parts
            done = run_task(task, payload, PipeContext(link, frame.token))
            _tell(link, frame.token, done)


def _tell(link: MessagePipe, token: int, done: TaskEnd) -> None:
    """Say how a task ended; after a crash this process is not to be trusted any more."""
    is_result = done.kind is MessageKind.RESULT
    body = two_parts(done.summary, done.text) if is_result else done.text.encode()
    link.send(Message(done.kind, token, body))
    if done.kind is MessageKind.CRASH:
        os._exit(_CRASH_CODE)
