"""HostMessage: what the dispatcher and a host of workers say to each other, in batches of bytes.

Bodies are JSON texts and bytes of artifacts, never pickles: neither end can make the other one run
anything but a task that both know.
"""

import struct
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum

from service.jobs.worker.protocol import MAX_BODY

_HEADER = struct.Struct(">IBIQ")
# What is sent at once, unless one message is longer [bytes].
BATCH = 4 * 1024 * 1024


class HostMessageKind(IntEnum):
    """What a message says; the first four go to the host, the next five come from it.

    RUN carries the task, its terms and its payload; CANCEL the grace [s]; CONTROLS all controls of
    the run; RECEIVED how many events were dealt with. READY says that a worker waits
    for its next run; MADE which artifacts a run has left on its host. ASK is about artifacts, and
    either end may ask; REPLY answers it.
    """

    RUN = 1
    CANCEL = 2
    CONTROLS = 3
    RECEIVED = 4
    READY = 11
    EVENT = 12
    UPDATE = 13
    OUTCOME = 14
    MADE = 15
    ASK = 21
    REPLY = 22


@dataclass(frozen=True)
class HostMessage:
    """A message about one worker of a host.

    Attributes:
        kind: What it says.
        worker: Which one; 0 where it is about none.
        run: Number of its run, so that what comes late is known as such; of an ASK and its REPLY,
            the number of the question.
        body: Text or bytes, perhaps in parts of which all but the last end with a line feed.
    """

    kind: HostMessageKind
    worker: int = 0
    run: int = 0
    body: bytes = b""

    @property
    def parts(self) -> tuple[str, str]:
        """The body up to its first line feed, and the rest."""
        first, _, rest = self.body.decode("utf-8").partition("\n")
        return first, rest


def pack(messages: Iterable[HostMessage]) -> bytes:
    """Return the bytes of messages, one after the other."""
    parts: list[bytes] = []
    for one in messages:
        parts += (_HEADER.pack(len(one.body), one.kind, one.worker, one.run), one.body)
    return b"".join(parts)


def unpack(batch: bytes) -> list[HostMessage]:
    """Return the messages that some bytes are.

    Raises:
        ValueError: They are none.
    """
    messages: list[HostMessage] = []
    place = 0
    while place < len(batch):
        begin = place + _HEADER.size
        if begin > len(batch):
            message = "a message is cut off in its header"
            raise ValueError(message)
        length, kind, worker, run = _HEADER.unpack_from(batch, place)
        place = begin + length
        if length > MAX_BODY or place > len(batch):
            message = f"a message of {length} bytes where there are {len(batch) - begin}"
            raise ValueError(message)
        body = bytes(batch[begin:place])
        messages.append(HostMessage(HostMessageKind(kind), worker, run, body))
    return messages


def batch_of(waiting: list[HostMessage]) -> list[HostMessage]:
    """Take as many messages out of a list as are sent at once, at least one if there is one."""
    size, count = 0, 0
    for one in waiting:
        size += _HEADER.size + len(one.body)
        if count and size > BATCH:
            break
        count += 1
    taken = waiting[:count]
    del waiting[:count]
    return taken
