"""Executions: motions that are being carried out."""

from datetime import datetime
from enum import StrEnum
from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, Json

from planning.execute import status as domain
from service.api.events import (
    EventData,
    EventId,
    FinishedEvent,
    QueuedEvent,
    StageEvent,
    StartedEvent,
)
from service.api.failures.failure import Failure
from service.api.models import (
    ATTEMPTS,
    CANCEL_REQUESTED_AT,
    UNRECORDED,
    Identifier,
    Real,
    RequestModel,
    ResponseModel,
    Timings,
)


class ExecutionState(StrEnum):
    """States of an execution: those of ROS 2 actions, and paused; the last three are final."""

    ACCEPTED = "accepted"
    EXECUTING = "executing"
    PAUSED = "paused"
    CANCELING = "canceling"
    SUCCEEDED = "succeeded"
    CANCELED = "canceled"
    ABORTED = "aborted"


class ExecutionRequest(RequestModel):
    """Carry out a plan."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"plan": "pln_5b1e9a7d4c623f0c", "driver": "simulated", "speed": 1.0}]
        }
    )

    plan: Identifier = Field(description="Id of a plan that succeeded")
    driver: Literal["simulated"] = Field(
        default="simulated", description="What moves: Drake's simulation under a joint controller"
    )
    speed: Annotated[Real, Field(gt=0, le=100)] = Field(
        default=1.0, description="Factor on the pace at which the simulation runs; 1 is real time"
    )
    title: Annotated[str, Field(min_length=1, max_length=200)] | None = Field(
        default=None, description="Title of the motion in replays of the scene"
    )


class Contact(ResponseModel):
    """Two bodies that touched during the motion."""

    bodies: tuple[str, str] = Field(description="Full names")
    depth: float = Field(description="Depth of penetration [m]")
    time: float = Field(description="Time along the motion [s]")


class ExecutionStatus(ResponseModel):
    """How far an execution is; also the data of its events."""

    state: ExecutionState = Field(description="State of the execution")
    progress: float = Field(
        description="Time along the motion over its duration, 0 to 1", ge=0, le=1
    )
    time: float = Field(description="Time along the motion [s]")
    positions: list[float] = Field(description="Measured positions [rad or m]")
    tracking_error: float = Field(
        description="Largest distance of a joint from where it should be, now [rad or m]"
    )
    max_tracking_error: float = Field(description="Largest tracking error so far [rad or m]")
    lateness: float | None = Field(
        default=None,
        description="The longest so far that the controller was late to look at the clock [s]: "
        "what else runs on the machine makes the motion fall behind; null if not recorded",
    )
    contacts: list[Contact] = Field(description="Touches so far that the scene does not allow")

    @classmethod
    def from_domain(
        cls,
        status: domain.ExecutionStatus,
        max_tracking_error: float,
        lateness: float,
        contacts: list[Contact],
    ) -> Self:
        """Return a status, with the worst of all before it."""
        return cls(
            state=ExecutionState(status.state),
            progress=min(1.0, max(0.0, status.progress)),
            time=status.time,
            positions=status.measured.tolist(),
            tracking_error=status.tracking_error,
            max_tracking_error=max_tracking_error,
            lateness=lateness,
            contacts=contacts,
        )


class StatusData(ExecutionStatus, EventData):
    """How far an execution is, and when it was there."""


class ControlsData(EventData):
    """What is asked of an execution from now on; what is left out stays as it was."""

    is_paused: bool | None = Field(default=None, description="Whether it rests on its path")
    speed: float | None = Field(default=None, description="Seconds of the motion per second")


class StatusEvent(ResponseModel):
    """The execution moves, or changes its state; at most twenty times a second."""

    id: EventId
    event: Literal["status"] = Field(description="What happened")
    data: Json[StatusData] = Field(description="How far it is")


class ControlsEvent(ResponseModel):
    """The execution was paused or resumed, or its speed set."""

    id: EventId
    event: Literal["controls"] = Field(description="What happened")
    data: Json[ControlsData] = Field(description="What is asked of it")


type ExecutionEvent = Annotated[
    QueuedEvent | StartedEvent | StageEvent | ControlsEvent | StatusEvent | FinishedEvent,
    Field(discriminator="event", description="What happened to an execution"),
]


class Execution(ResponseModel):
    """An execution of a plan; poll it until its state is final."""

    id: str = Field(description="Id of the execution")
    state: ExecutionState = Field(description="succeeded, canceled and aborted are final")
    created_at: datetime = Field(description="When it was asked for (UTC)")
    started_at: datetime | None = Field(description="When it began to move (UTC)")
    finished_at: datetime | None = Field(description="When it ended (UTC)")
    cancel_requested_at: datetime | None = Field(description=CANCEL_REQUESTED_AT)
    attempts: int = Field(description=ATTEMPTS)
    request: ExecutionRequest = Field(description="The request, defaults filled in")
    scene: str = Field(description="Id of the scene it moves in")
    group: str = Field(description="Group that moves")
    status: ExecutionStatus | None = Field(description="The latest status; null before it began")
    failure: Failure | None = Field(description="Why it was aborted or canceled")
    timings: Timings = Field(
        default={},
        description="Seconds of the stages `load` and `execute`, once it has ended; of a failure "
        "those of `failure` [s]",
    )
    unrecorded: list[str] = Field(description=UNRECORDED)


class ExecutionPage(ResponseModel):
    """Executions, newest first."""

    items: list[Execution] = Field(description="Executions on this page")
    next: str | None = Field(description="Cursor of the next page; null on the last one")


class SpeedRequest(RequestModel):
    """Change how fast a motion is carried out."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"speed": 0.5}]})

    speed: Annotated[Real, Field(gt=0, le=100)] = Field(
        description="Seconds of the motion per second; above 1 only a simulation can do"
    )
