"""The live state of a scene as a resource, and as the event that tells of it."""

from datetime import datetime
from typing import Annotated, Literal, Self

from pydantic import Field, Json

from service.api.events import EventId
from service.api.models import ResponseModel
from service.scenes import live as domain

type JointPositions = Annotated[
    dict[str, float | list[float]],
    Field(
        description="Positions by joint of the robot: a number, or one for each of its coordinates"
    ),
]


class DocumentSource(ResponseModel):
    """The scene's document has the robot there."""

    type: Literal["document"] = Field(description="What says where the robot is")
    revision: int = Field(description="Whose document it is: the latest")


class EditSource(ResponseModel):
    """The robot was put there by hand, by `set_positions`."""

    type: Literal["edit"] = Field(description="What says where the robot is")
    revision: int = Field(description="Revision that the edit made")


class ExecutionSource(ResponseModel):
    """An execution has measured the robot there."""

    type: Literal["execution"] = Field(description="What says where the robot is")
    id: str = Field(description="Id of the execution")


type StateSource = Annotated[
    DocumentSource | EditSource | ExecutionSource,
    Field(discriminator="type", description="What says where the robot is"),
]


class RobotState(ResponseModel):
    """Where a robot is."""

    robot: str = Field(description="Its name in the scene")
    status: domain.RobotStatus = Field(
        description="`at_rest`; `moving`, by an execution; or `unknown`: an execution has ended "
        "without its driver, and nothing in the scene moves until `set_positions` says where it is"
    )
    positions: JointPositions = Field(
        description="Positions of the joints of its groups [rad or m]; `set_positions` takes "
        "them as they are"
    )
    velocities: JointPositions | None = Field(
        description="Measured [rad/s or m/s]; null where its driver does not tell"
    )
    source: StateSource = Field(description="What says where it is")
    updated_at: datetime = Field(description="When that was said last (UTC)")
    execution: str | None = Field(description="Execution that moves it, or waits to; null for none")

    @classmethod
    def of(cls, state: domain.RobotState) -> Self:
        """Return where a robot is as clients see it."""
        return cls(
            robot=state.robot,
            status=state.status,
            positions=dict(state.positions),
            velocities=None if state.velocities is None else dict(state.velocities),
            source=_source(state.source),
            updated_at=state.updated_at,
            execution=state.execution,
        )


class HeldObject(ResponseModel):
    """An object that a robot holds."""

    object: str = Field(description="Its name")
    frame: str = Field(description="Frame of a robot that it is attached to")


class GripperState(ResponseModel):
    """How wide a gripper is open, and what it holds."""

    group: str = Field(description="Its full name")
    robot: str = Field(description="Whose gripper it is")
    width: float = Field(description="How far apart its fingers are [m], as `positions` has them")
    max_width: float = Field(description="How far apart they can be [m]")
    holds: list[str] = Field(description="Objects that are attached to a frame of the gripper")


class LiveState(ResponseModel):
    """Where the robots of a scene are now, and what they hold."""

    scene: str = Field(description="Id of the scene")
    revision: int = Field(description="The latest; executions do not change it")
    robots: list[RobotState] = Field(description="Those that have joints")
    attached: list[HeldObject] = Field(description="What robots hold")
    grippers: list[GripperState] = Field(
        default=[], description="Groups that are grippers, and how wide they are open"
    )


class StateEvent(ResponseModel):
    """The live state as it is now; what was between two events is not told."""

    id: EventId
    event: Literal["state"] = Field(description="What happened")
    data: Json[LiveState] = Field(description="The live state, whole")


def _source(source: domain.Source) -> StateSource:
    match source:
        case domain.DocumentSource(revision):
            return DocumentSource(type="document", revision=revision)
        case domain.EditSource(revision):
            return EditSource(type="edit", revision=revision)
        case domain.ExecutionSource(execution):
            return ExecutionSource(type="execution", id=execution)
