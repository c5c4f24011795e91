"""Server-sent events, decoded.

https://html.spec.whatwg.org/multipage/server-sent-events.html#event-stream-interpretation
"""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Event:
    """Something that happened to a job.

    Attributes:
        id: For `Last-Event-ID`.
        type: queued, started, stage, progress, status, finished, ...
        data: What is known of it.
    """

    id: str
    type: str
    data: dict[str, Any]


def decode_events(lines: Iterable[str]) -> Iterator[Event]:
    """Yield the events in the lines of a `text/event-stream`; comments are skipped."""
    fields: dict[str, str] = {}
    for line in lines:
        if line:
            name, _, rest = line.partition(":")
            if name:
                fields[name] = rest.removeprefix(" ")
        elif "data" in fields:
            yield Event(fields.get("id", ""), fields.get("event", ""), json.loads(fields["data"]))
            fields = {}
        else:
            fields = {}
