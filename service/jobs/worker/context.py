"""What a task has of the server while it runs in a process: events out, controls and cancels in."""

import json
from typing import Any

from service.jobs.json_text import encode_leniently
from service.jobs.worker.protocol import Message, MessageKind, MessagePipe, two_parts
from service.jobs.worker.run_task import event_text


class PipeContext:
    """A task's events, time limits and controls over the pipe to its worker."""

    def __init__(self, pipe: MessagePipe, token: int) -> None:
        """Speak for the run that `token` numbers."""
        self._pipe = pipe
        self._token = token
        self._is_canceled = False
        self._controls: dict[str, Any] = {}

    def emit(self, event_type: str, data: dict[str, Any]) -> None:
        """Send an event; waits if the server does not keep up."""
        self._send(MessageKind.EVENT, two_parts(event_type, event_text(data)))

    def emit_whole(self, event_type: str, data: dict[str, Any]) -> None:
        """Send an event, however long it is."""
        self._send(MessageKind.EVENT, two_parts(event_type, encode_leniently(data)))

    def update(self, event_type: str, data: dict[str, Any]) -> None:
        """Send an event that the next of its type may replace."""
        self._send(MessageKind.UPDATE, two_parts(event_type, event_text(data)))

    def allow(self, seconds: float, grace: float = 0.0) -> None:
        """Have this run ended after some seconds from now on, and not before."""
        self._send(MessageKind.DEADLINE, json.dumps([seconds, grace]).encode())

    def watch(self, silence: float) -> None:
        """Have this process ended if it says nothing for so long, from now on."""
        self._send(MessageKind.WATCH, repr(silence).encode())

    def controls(self) -> dict[str, Any]:
        """Return all controls that were set for this run."""
        self._receive()
        return self._controls

    def is_canceled(self) -> bool:
        """Return whether the end of this run was requested."""
        self._receive()
        return self._is_canceled

    def _send(self, kind: MessageKind, body: bytes) -> None:
        self._pipe.send(Message(kind, self._token, body))

    def _receive(self) -> None:
        """Apply what has come; what comes after a cancel is left unread."""
        while not self._is_canceled and self._pipe.has_message:
            message = self._pipe.receive()
            if message is None:  # without the server the answer has no use
                self._is_canceled = True
            elif message.token == self._token:  # what was for an earlier run is stale
                self._apply(message)

    def _apply(self, message: Message) -> None:
        if message.kind is MessageKind.CONTROLS:
            self._controls = json.loads(message.body)
        else:
            self._is_canceled = True


class SilentContext:
    """For a task that no server follows, such as the warm-up: drops events and limits."""

    def emit(self, event_type: str, data: dict[str, Any]) -> None:
        """Drop an event."""

    def emit_whole(self, event_type: str, data: dict[str, Any]) -> None:
        """Drop an event."""

    def update(self, event_type: str, data: dict[str, Any]) -> None:
        """Drop an event."""

    def allow(self, seconds: float, grace: float = 0.0) -> None:
        """Do nothing: what nothing follows has no limit."""

    def watch(self, silence: float) -> None:
        """Do nothing: what nothing follows may be silent."""

    def controls(self) -> dict[str, Any]:
        """Return that none is set."""
        return {}

    def is_canceled(self) -> bool:
        """Return that it is not."""
        return False
