"""Events of a job, from a stream of server-sent events."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import httpx
from httpx_sse import EventSource


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


def decode_events(response: httpx.Response) -> Iterator[Event]:
    """Yield the events of a response, which is read on the way; those without data are skipped.

    Raises:
        SSEError: It is no stream of events.
    """
    for event in EventSource(response).iter_sse():
        if event.data:
            yield Event(event.id, event.event, event.json())
