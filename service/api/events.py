"""Events of jobs: what is streamed of plans and regions."""

from datetime import datetime
from typing import Annotated, Literal

from pydantic import Field, Json

from service.api.document.open_enums import Stage
from service.api.failures.failure import Failure
from service.api.models import ResponseModel, Timings

type EventId = Annotated[str, Field(description="Id of the event, for `Last-Event-ID`")]


class EventData(ResponseModel):
    """Data that every event has."""

    at: datetime = Field(description="Time at which it happened (UTC)")
    plan: str | None = Field(
        default=None,
        description="Id of the plan, in the stream of a batch; absent in other streams",
    )


class RequeuedData(EventData):
    """Why a job runs again."""

    reason: str = Field(description="Text for a person")


class ProgressData(EventData):
    """Progress of a job."""

    stage: Stage = Field(description="The stage that it is in")
    progress: float = Field(description="Share of the whole job, 0 to 1")
    detail: str = Field(description="Text for a person, or empty")


class StageData(ProgressData):
    """Stage that begins."""

    timings: Timings = Field(description="Seconds of the stages before it")


class BestPathData(EventData):
    """A path that is better than those before it."""

    detail: str = Field(description="Text for a person")
    length: float = Field(description="Weighted length of the path")
    seconds: float | None = Field(
        default=None,
        description="Time since the worker began with the plan [s]; null where an older "
        "version told it",
    )
    waypoints: list[list[float]] | None = Field(
        default=None,
        description="Configurations along the path from the start to a goal, at most 64 of its "
        "waypoints; to look at, not to move along: nothing is proven of it, and a path that is "
        "still improved is checked coarsely. Null where the planner tells the length only",
    )


class FinishedData(EventData):
    """End of a job."""

    state: Literal["succeeded", "failed", "canceled"] = Field(description="Final state of the job")
    failure: Failure | None = Field(default=None, description="Reason why there is no result")


class QueuedEvent(ResponseModel):
    """The job was accepted."""

    id: EventId
    event: Literal["queued"] = Field(description="Kind of the event")
    data: Json[EventData] = Field(description="Time of the event")


class StartedEvent(ResponseModel):
    """A worker took the job."""

    id: EventId
    event: Literal["started"] = Field(description="Kind of the event")
    data: Json[EventData] = Field(description="Time of the event")


class RequeuedEvent(ResponseModel):
    """The job waits again: its worker or the server ended."""

    id: EventId
    event: Literal["requeued"] = Field(description="Kind of the event")
    data: Json[RequeuedData] = Field(description="Time and reason of the event")


class StageEvent(ResponseModel):
    """The job enters a stage."""

    id: EventId
    event: Literal["stage"] = Field(description="Kind of the event")
    data: Json[StageData] = Field(
        description="Stage that begins, and the time that those before it took"
    )


class ProgressEvent(ResponseModel):
    """The job is further, at most twenty times a second."""

    id: EventId
    event: Literal["progress"] = Field(description="Kind of the event")
    data: Json[ProgressData] = Field(description="Progress of the job")


class BestSoFarEvent(ResponseModel):
    """The search found a better path."""

    id: EventId
    event: Literal["best-so-far"] = Field(description="Kind of the event")
    data: Json[BestPathData] = Field(description="The better path")


class FinishedEvent(ResponseModel):
    """The job ended; no event follows."""

    id: EventId
    event: Literal["finished"] = Field(description="Kind of the event")
    data: Json[FinishedData] = Field(description="End of the job")


type JobEvent = Annotated[
    QueuedEvent
    | StartedEvent
    | RequeuedEvent
    | StageEvent
    | ProgressEvent
    | BestSoFarEvent
    | FinishedEvent,
    Field(discriminator="event", description="Event of a plan or of regions"),
]
