"""What a task has of the server while it runs in a process: events out, controls in."""

import json
from typing import Any

from service.jobs.task import event_text
from service.jobs.worker.protocol import Message, MessageKind, MessagePipe, two_parts


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


class WarmUpContext:
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
