"""Events of jobs, from a stream of server-sent events."""

import json
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from typing import Any

import httpx
from httpx_sse import EventSource


@dataclass(frozen=True)
class Event:
    """Something that happened to a job, as it came.

    Attributes:
        id: For `Last-Event-ID`.
        type: queued, started, stage, progress, status, finished, ...
        data: What is known of it.
    """

    id: str
    type: str
    data: dict[str, Any]

    @property
    def document(self) -> dict[str, str]:
        """Return it as the OpenAPI document has it: its data as a text."""
        return {"id": self.id, "event": self.type, "data": json.dumps(self.data)}


def decode_events(response: httpx.Response) -> Iterator[Event]:
    """Yield the events of a response, which is read on the way; those without data are skipped.

    Raises:
        SSEError: It is no stream of events.
    """
    for event in EventSource(response).iter_sse():
        if event.data:
            yield Event(event.id, event.event, event.json())


async def async_decode_events(response: httpx.Response) -> AsyncIterator[Event]:
    """Yield events as `decode_events` does."""
    async for event in EventSource(response).aiter_sse():
        if event.data:
            yield Event(event.id, event.event, event.json())
