"""Events of a job as server-sent events."""

from collections.abc import AsyncIterator
from typing import Any

from fastapi.sse import ServerSentEvent

from service.api.events import JobEvent
from service.jobs.job import JobSummary, LoggedEvent
from service.jobs.service import JobService

EVENTS: dict[str, Any] = {
    "description": "Server-sent events, each as the schema has it; the stream ends with the job",
    "model": JobEvent,
}


async def server_sent(
    jobs: JobService, job: JobSummary, last_event_id: str | None
) -> AsyncIterator[ServerSentEvent]:
    """Yield what happened to a job after an event, and what happens from now on, to its end."""
    # An id that is not ours is from another stream: then everything is sent.
    is_ours = last_event_id is not None and last_event_id.isdecimal()
    async for event in jobs.events(job, int(last_event_id) if is_ours and last_event_id else 0):
        yield ServerSentEvent(id=str(event.number), event=event.type, data=data_of(event))


def data_of(event: LoggedEvent) -> dict[str, Any]:
    """Return what a stream tells of an event."""
    return {"at": event.at.replace("+00:00", "Z"), **event.data}
