"""Events of jobs: what is streamed of plans and regions."""

from datetime import datetime
from typing import Annotated, Literal

from pydantic import Field, Json

from service.api.document.open_enums import Stage
from service.api.failures.failure import Failure
from service.api.models import ResponseModel, Timings

type EventId = Annotated[str, Field(description="For `Last-Event-ID`")]


class EventData(ResponseModel):
    """What every event says."""

    at: datetime = Field(description="When it happened (UTC)")
    plan: str | None = Field(
        default=None,
        description="Id of the plan, in the stream of a batch; absent in other streams",
    )


class RequeuedData(EventData):
    """Why a job runs again."""

    reason: str = Field(description="Text for a person")


class ProgressData(EventData):
    """How far a job is."""

    stage: Stage = Field(description="The stage that it is in")
    progress: float = Field(description="Share of the whole job, 0 to 1")
    detail: str = Field(description="Text for a person, or empty")


class StageData(ProgressData):
    """Which stage begins."""

    timings: Timings = Field(description="Seconds of the stages before it")


class BestPathData(EventData):
    """A path that is better than those before it."""

    detail: str = Field(description="Text for a person")
    length: float = Field(description="Weighted length of the path")
    seconds: float | None = Field(
        default=None,
        description="Since the worker began with the plan [s]; null where an older version told it",
    )


class FinishedData(EventData):
    """How a job ended."""

    state: Literal["succeeded", "failed", "canceled"] = Field(description="Final state of the job")
    failure: Failure | None = Field(default=None, description="Why there is no result")


class QueuedEvent(ResponseModel):
    """The job was accepted."""

    id: EventId
    event: Literal["queued"] = Field(description="What happened")
    data: Json[EventData] = Field(description="When")


class StartedEvent(ResponseModel):
    """A worker took the job."""

    id: EventId
    event: Literal["started"] = Field(description="What happened")
    data: Json[EventData] = Field(description="When")


class RequeuedEvent(ResponseModel):
    """The job waits again: its worker or the server ended."""

    id: EventId
    event: Literal["requeued"] = Field(description="What happened")
    data: Json[RequeuedData] = Field(description="When and why")


class StageEvent(ResponseModel):
    """The job enters a stage."""

    id: EventId
    event: Literal["stage"] = Field(description="What happened")
    data: Json[StageData] = Field(description="Which stage, and how long those before it took")


class ProgressEvent(ResponseModel):
    """The job is further, at most twenty times a second."""

    id: EventId
    event: Literal["progress"] = Field(description="What happened")
    data: Json[ProgressData] = Field(description="How far it is")


class BestSoFarEvent(ResponseModel):
    """The search found a better path."""

    id: EventId
    event: Literal["best-so-far"] = Field(description="What happened")
    data: Json[BestPathData] = Field(description="How long the path is")


class FinishedEvent(ResponseModel):
    """The job ended; no event follows."""

    id: EventId
    event: Literal["finished"] = Field(description="What happened")
    data: Json[FinishedData] = Field(description="How it ended")


type JobEvent = Annotated[
    QueuedEvent
    | StartedEvent
    | RequeuedEvent
    | StageEvent
    | ProgressEvent
    | BestSoFarEvent
    | FinishedEvent,
    Field(discriminator="event", description="What happened to a plan or to regions"),
]
