"""Executions: motions that are being carried out."""

from datetime import datetime
from enum import StrEnum
from typing import Annotated, Literal, Self

from pydantic import Field, Json

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
    ResponseModel,
    Timings,
)
from service.executions.gripping.held import HeldStatus
from service.executions.requests import ExecutionTerms
from service.plans.models.trajectory import Polynomial

# Of velocities and torques: twenty statuses a second are kept.
_DECIMALS = 6


class ExecutionState(StrEnum):
    """States of an execution: those of ROS 2 actions, paused, aborting; the last three are final.

    One that is aborting has failed, and its robot comes to rest.
    """

    ACCEPTED = "accepted"
    EXECUTING = "executing"
    PAUSED = "paused"
    CANCELING = "canceling"
    ABORTING = "aborting"
    SUCCEEDED = "succeeded"
    CANCELED = "canceled"
    ABORTED = "aborted"


class Contact(ResponseModel):
    """Two bodies that touched during the motion."""

    bodies: tuple[str, str] = Field(description="Full names")
    depth: float = Field(description="Largest depth of penetration [m]")
    force: float | None = Field(
        default=None, description="Largest force between them [N]; null if it is not known"
    )
    time: float = Field(description="Time along the motion of the first touch [s]")


class Jitter(ResponseModel):
    """Delays of the ticks of the controller."""

    ticks: int = Field(description="Number of ticks")
    median: float = Field(description="Median delay, at most 5 % too large [s]")
    p99: float = Field(description="99th percentile, at most 5 % too large [s]")
    max: float = Field(description="Largest delay [s]")


class ExecutionStatus(ResponseModel):
    """Progress of an execution; also the data of its events."""

    state: ExecutionState = Field(description="State of the execution")
    progress: float = Field(
        description="Share of the path's length that is done, 0 to 1, by place, not by the clock: "
        "it shrinks on the way back",
        ge=0,
        le=1,
    )
    time: float = Field(description="Time along the motion [s]")
    path_velocity: float | None = Field(
        default=None,
        description="Seconds of the motion per second of the robot's clock, now; negative is "
        "backwards; null if not recorded",
    )
    positions: list[float] = Field(description="Measured positions [rad or m]")
    velocities: list[float] | None = Field(
        default=None, description="Measured velocities [rad/s or m/s]; null if not recorded"
    )
    torques: list[float] | None = Field(
        default=None,
        description="Measured torques or forces of the motors [N m or N]; null if not known",
    )
    tracking_error: float = Field(
        description="Largest distance of a joint from where it should be, now [rad or m]"
    )
    max_tracking_error: float = Field(description="Largest tracking error so far [rad or m]")
    lateness: float | None = Field(
        default=None,
        description="Longest delay so far with which the controller looked at the clock "
        "[s]; load on the machine makes the motion fall behind; null if not "
        "recorded",
    )
    jitter: Jitter | None = Field(
        default=None,
        description="Delays of the controller's ticks so far; null if not recorded",
    )
    contacts: list[Contact] = Field(description="Touches so far that the scene does not allow")
    motion: int = Field(
        default=0,
        description="Number of the motion that `time` and `progress` are about: 0 is the one that "
        "was asked for, the others are in `motions`",
    )
    ahead: float | None = Field(
        default=None,
        description="Time along the motion that it does not pass [s]: it rests before it "
        "until an edit of the scene clears the way; null for none",
    )
    behind: float | None = Field(
        default=None,
        description="Time along the motion that it does not pass on the way back [s]; "
        "null for none",
    )
    held: list[HeldStatus] = Field(
        default=[],
        description="Objects that are held by contact and moved along, where the driver measures "
        "them",
    )

    @classmethod
    def from_domain(
        cls,
        status: domain.ExecutionStatus,
        max_tracking_error: float,
        jitter: Jitter,
        contacts: list[Contact],
    ) -> Self:
        """Return a status, with the worst of all before it."""
        return cls(
            state=ExecutionState(status.state),
            progress=min(1.0, max(0.0, status.progress)),
            time=status.time,
            path_velocity=status.path_velocity,
            positions=status.measured.tolist(),
            velocities=status.velocities.round(_DECIMALS).tolist(),
            torques=None if status.torques is None else status.torques.round(_DECIMALS).tolist(),
            tracking_error=status.tracking_error,
            max_tracking_error=max_tracking_error,
            lateness=jitter.max,
            jitter=jitter,
            contacts=contacts,
            ahead=status.ahead,
            behind=status.behind,
            held=[HeldStatus.from_domain(held) for held in status.held],
        )


class StatusData(ExecutionStatus, EventData):
    """Progress of an execution, and the time of it."""


class ControlsData(EventData):
    """Controls of an execution from now on; those that are left out stay as they were."""

    is_paused: bool | None = Field(default=None, description="Whether it rests on its path")
    speed: float | None = Field(
        default=None, description="Seconds of the motion per second; negative is backwards"
    )


class FollowedMotion(ResponseModel):
    """A motion that an execution went on with, since an edit was in the way of the one before."""

    number: int = Field(
        description="Number of the motion; 1 is the first one after the requested motion"
    )
    plan: str = Field(description="Id of the plan that it follows")
    revision: int = Field(description="Revision of the scene in which it is proven")
    is_spliced: bool = Field(
        description="Whether the robot left the motion before it without a rest; if not, it began "
        "at rest, where the robot had stopped"
    )
    left_at: float = Field(description="Place on the motion before it where that was left [s]")
    duration: float = Field(description="Duration of the whole motion [s]")


class MotionData(EventData):
    """A motion that is followed from now on."""

    number: int = Field(description="Number of the motion")
    motions: list[FollowedMotion] = Field(description="All motions so far, this one last")
    trajectory: Polynomial = Field(
        description="The whole motion; a spliced one has what was passed of the motion before it"
    )


class MotionEvent(ResponseModel):
    """The execution goes on with another motion."""

    id: EventId
    event: Literal["motion"] = Field(description="Kind of the event")
    data: Json[MotionData] = Field(description="The motion that is followed from now on")


class StatusEvent(ResponseModel):
    """The execution moves, or changes its state; at most twenty times a second."""

    id: EventId
    event: Literal["status"] = Field(description="Kind of the event")
    data: Json[StatusData] = Field(description="Progress of the execution")


class ControlsEvent(ResponseModel):
    """The execution was paused or resumed, or its speed set."""

    id: EventId
    event: Literal["controls"] = Field(description="Kind of the event")
    data: Json[ControlsData] = Field(description="The new controls")


type ExecutionEvent = Annotated[
    QueuedEvent
    | StartedEvent
    | StageEvent
    | ControlsEvent
    | StatusEvent
    | MotionEvent
    | FinishedEvent,
    Field(discriminator="event", description="Event of an execution"),
]


class SamplingReserve(ResponseModel):
    """Clearance that a controller leaves which samples and smooths the motion."""

    deviation: float = Field(description="Largest distance of a joint from the path [rad]")
    approach: float = Field(
        description="Largest loss of distance between two bodies because of the controller [m]"
    )
    clearance: float | None = Field(
        description="Proven lower bound on all distances along the path [m]; null without any pair"
    )


class Replanned(ResponseModel):
    """A plan that is carried out instead of the motion that was asked for."""

    plan: str = Field(description="Id of the plan")
    code: str = Field(description="Code that the execution would have been refused with")
    detail: str = Field(description="Reason of that refusal, for a person")


class Execution(ResponseModel):
    """An execution of a motion; poll it until its state is final."""

    id: str = Field(description="Id of the execution")
    state: ExecutionState = Field(description="succeeded, canceled and aborted are final")
    created_at: datetime = Field(description="Time of the request (UTC)")
    started_at: datetime | None = Field(description="Time at which it began to move (UTC)")
    finished_at: datetime | None = Field(description="Time at which it ended (UTC)")
    cancel_requested_at: datetime | None = Field(description=CANCEL_REQUESTED_AT)
    attempts: int = Field(description=ATTEMPTS)
    request: ExecutionTerms = Field(
        description="The request, defaults filled in, without a motion of one's own"
    )
    scene: str = Field(description="Id of the scene it moves in")
    group: str = Field(description="Group that moves; of several plans the one that spans theirs")
    delays: list[float] | None = Field(
        default=None, description="Time at which each of `plans` begins [s]; null for one motion"
    )
    is_waiting: bool = Field(
        default=False, description="Whether it waits for its robots, and is proven once it begins"
    )
    status: ExecutionStatus | None = Field(description="The latest status; null before it began")
    replanned: Replanned | None = Field(
        default=None,
        description="Plan that is carried out instead, as `on_not_certified` says; null "
        "if the requested motion held",
    )
    motions: list[FollowedMotion] = Field(
        default=[],
        description="Motions that it went on with instead of the requested one, in order",
    )
    failure: Failure | None = Field(description="Reason why it was aborted or canceled")
    timings: Timings = Field(
        default={},
        description="Seconds of the stages `load` and `execute`, once it has ended; of a failure "
        "those of `failure` [s]",
    )
    sampling: SamplingReserve | None = Field(
        default=None,
        description="Effect of a controller that samples the motion, once it has ended; null "
        "for others",
    )
    unrecorded: list[str] = Field(description=UNRECORDED)


class ExecutionPage(ResponseModel):
    """Executions, newest first."""

    items: list[Execution] = Field(description="Executions on this page")
    next: str | None = Field(description="Cursor of the next page; null on the last one")
