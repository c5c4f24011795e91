"""The live state of a scene as a resource, and as the event that tells of it."""

from datetime import datetime
from typing import Annotated, Literal, Self

from pydantic import Field, Json

from service.api.events import EventId
from service.api.models import ResponseModel
from service.executions.gripping.held import MeasuredPose
from service.scenes import live as domain

type JointPositions = Annotated[
    dict[str, float | list[float]],
    Field(
        description="Positions by joint of the robot: a number, or one for each of its coordinates"
    ),
]


class DocumentSource(ResponseModel):
    """The scene's document has the robot there."""

    type: Literal["document"] = Field(description="Kind of source")
    revision: int = Field(description="Revision of the document: the latest")


class EditSource(ResponseModel):
    """The robot was put there by hand, by `set_positions`."""

    type: Literal["edit"] = Field(description="Kind of source")
    revision: int = Field(description="Revision that the edit made")


class ExecutionSource(ResponseModel):
    """An execution has measured the robot there."""

    type: Literal["execution"] = Field(description="Kind of source")
    id: str = Field(description="Id of the execution")


type StateSource = Annotated[
    DocumentSource | EditSource | ExecutionSource,
    Field(discriminator="type", description="Source of a robot's positions"),
]


class RobotState(ResponseModel):
    """Present state of a robot."""

    robot: str = Field(description="Name of the robot in the scene")
    status: domain.RobotStatus = Field(
        description="Status: `at_rest`; `moving`, by an execution; or `unknown`: an "
        "execution has ended without its driver, and nothing in the scene "
        "moves until `set_positions` says where the robot is"
    )
    positions: JointPositions = Field(
        description="Positions of the joints of its groups [rad or m]; `set_positions` takes "
        "them as they are"
    )
    velocities: JointPositions | None = Field(
        description="Measured velocities [rad/s or m/s]; null where its driver does not tell"
    )
    source: StateSource = Field(description="Source of its positions")
    updated_at: datetime = Field(description="Time at which its source said so last (UTC)")
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

    object: str = Field(description="Name of the object")
    frame: str = Field(description="Frame of a robot that it is attached to")
    by: Literal["weld", "contact"] = Field(
        default="weld", description="How it is held: welded, or by the friction of fingers"
    )
    pose: MeasuredPose | None = Field(
        default=None,
        description="Pose in that frame: as measured while its robot moves, else as the latest "
        "revision has it",
    )
    slip: float | None = Field(
        default=None,
        description="Largest distance of a corner of its bounding box from where it was proven to "
        "be held, as measured while its robot moves [m]; null where nothing is measured",
    )
    is_lost: bool = Field(
        default=False, description="Whether it has left its place in the gripper that moves"
    )


class GripperState(ResponseModel):
    """Width of a gripper, and the objects that it holds."""

    group: str = Field(description="Full name of the gripper")
    robot: str = Field(description="Robot that the gripper belongs to")
    width: float = Field(description="Distance of the fingers [m], as `positions` has them")
    max_width: float = Field(description="Largest distance that the fingers can have [m]")
    holds: list[str] = Field(description="Objects that are attached to a frame of the gripper")


class LiveState(ResponseModel):
    """Present positions of the robots of a scene, and the objects that they hold."""

    scene: str = Field(description="Id of the scene")
    revision: int = Field(description="Latest revision; executions do not change it")
    robots: list[RobotState] = Field(description="Robots that have joints")
    attached: list[HeldObject] = Field(description="Objects that robots hold")
    grippers: list[GripperState] = Field(
        default=[], description="Groups that are grippers, and how wide they are open"
    )


class StateEvent(ResponseModel):
    """The live state as it is now; what was between two events is not told."""

    id: EventId
    event: Literal["state"] = Field(description="Kind of the event")
    data: Json[LiveState] = Field(description="The live state, whole")


def _source(source: domain.Source) -> StateSource:
    match source:
        case domain.DocumentSource(revision):
            return DocumentSource(type="document", revision=revision)
        case domain.EditSource(revision):
            return EditSource(type="edit", revision=revision)
        case domain.ExecutionSource(execution):
            return ExecutionSource(type="execution", id=execution)
