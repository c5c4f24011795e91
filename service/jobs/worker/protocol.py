"""Messages: what a worker and its process say to each other over a socket.

Both ends speak JSON texts, never pickles: a process whose memory native code has damaged cannot
make the server run anything.
"""

import json
import select
import socket
import struct
import sys
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from planning.errors import PlanningFailure, StageFailure, WayproofError
from service.jobs.json_text import encode_leniently

_HEADER = struct.Struct(">IBQ")
HEADER_SIZE = _HEADER.size
# More than any result; a length beyond it is noise from a damaged process.
MAX_BODY = 512 * 1024 * 1024


class MessageKind(IntEnum):
    """What a message says; TASK, CANCEL and CONTROLS go to the process, the others come from it.

    TASK carries its name and the ids that it is run for as a JSON list, then its payload.
    CONTROLS carries all controls of the run, as JSON. READY carries why the network is reached
    where it should not be, and how the warm-up failed, if it did; TERM how many seconds the run has
    from now on; WATCH how long it may be silent [s]. UPDATE is an event that a later one of its
    type may replace.
    """

    TASK = 1
    CANCEL = 2
    READY = 3
    EVENT = 4
    RESULT = 5
    FAILURE = 6
    CRASH = 7
    DEADLINE = 8
    CONTROLS = 9
    WATCH = 10
    UPDATE = 11


@dataclass(frozen=True)
class Message:
    """A message about one run.

    Attributes:
        kind: What it says.
        token: Number of the run, so that what comes late is known as such.
        body: Text, perhaps in two parts of which the first ends with a line feed.
    """

    kind: MessageKind
    token: int
    body: bytes = b""

    @property
    def parts(self) -> tuple[str, str]:
        """The body up to its first line feed, and the rest."""
        first, _, rest = self.body.decode("utf-8").partition("\n")
        return first, rest

    def packed(self) -> bytes:
        """Return the bytes of the message."""
        return _HEADER.pack(len(self.body), self.kind, self.token) + self.body


def two_parts(first: str, rest: str) -> bytes:
    """Return the body that `Message.parts` takes apart; `first` loses its line feeds."""
    return f"{first.replace('\n', ' ')}\n{rest}".encode()


def unpack_header(header: bytes) -> tuple[int, MessageKind, int]:
    """Return the length of the body, the kind and the token.

    Raises:
        ValueError: It is no header.
    """
    length, kind, token = _HEADER.unpack(header)
    if length > MAX_BODY:
        message = f"a message of {length} bytes"
        raise ValueError(message)
    return length, MessageKind(kind), token


class MessagePipe:
    """The process's end of the socket; blocking."""

    def __init__(self, end: socket.socket) -> None:
        """Speak over a connected stream socket."""
        self._end = end
        self._poll = select.poll()
        self._poll.register(end, select.POLLIN)

    def send(self, message: Message) -> None:
        """Send a message."""
        self._end.sendall(message.packed())

    @property
    def has_message(self) -> bool:
        """Whether something has come; takes a microsecond."""
        return bool(self._poll.poll(0))

    def receive(self) -> Message | None:
        """Return the next message, None if the other end is gone."""
        header = self._exactly(HEADER_SIZE)
        if header is None:
            return None
        length, kind, token = unpack_header(header)
        body = self._exactly(length)
        return None if body is None else Message(kind, token, body)

    def _exactly(self, count: int) -> bytes | None:
        parts: list[bytes] = []
        while count > 0:
            part = self._end.recv(min(count, 1 << 20))
            if not part:
                return None
            parts.append(part)
            count -= len(part)
        return b"".join(parts)


class RemoteFailure(PlanningFailure):
    """An error whose class the server does not know; it keeps its code, stage and timings."""

    # Module and name of its class, for those it is passed on to.
    origin: tuple[str, str] = ("", "")

    def __init__(self, code: str, stage: str, detail: str, evidence: dict[str, Any]) -> None:
        super().__init__(detail, evidence)
        self.code = code  # pyright: ignore[reportAttributeAccessIssue]
        self.stage = stage


def dump_error(error: WayproofError) -> str:
    """Return the text of an error."""
    kind = type(error)
    own = (kind.__module__, kind.__qualname__)
    module, name = error.origin if isinstance(error, RemoteFailure) else own
    fields = {
        "module": module,
        "name": name,
        "code": error.code,
        "stage": str(getattr(error, "stage", "")),
        "timings": dict(getattr(error, "timings", {})),
        "detail": error.detail,
    }
    evidence = encode_leniently(error.evidence)
    return f'{encode_leniently(fields)[:-1]},"evidence":{evidence}}}'


def load_error(text: str) -> WayproofError:
    """Return the error in a text, of its own class if the server has loaded it."""
    fields = json.loads(text)
    evidence = dict(fields["evidence"])
    kind = getattr(sys.modules.get(fields["module"]), fields["name"], None)
    error: WayproofError
    if isinstance(kind, type) and issubclass(kind, WayproofError) and kind.code == fields["code"]:
        error = kind(fields["detail"], evidence)
    else:
        error = RemoteFailure(fields["code"], fields["stage"], fields["detail"], evidence)
        error.origin = fields["module"], fields["name"]
    if isinstance(error, StageFailure):
        error.in_stage(fields["stage"]).timings = dict(fields["timings"])
    return error
