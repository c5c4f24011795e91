"""SceneEdit: operations that make the next revision of a scene."""

from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, Strict, model_validator

from planning.domain.scene import scene_operation as domain
from planning.world.documents.scene_document import GripDocument, ObjectDocument, PoseDocument
from service.api.fingerprint import ADDED
from service.api.models import WHOLE, Boolean, Coordinate, Name, Positions, RequestModel

type BodyNames = Annotated[list[Name], Field(min_length=2, max_length=2)]

EXAMPLE: dict[str, Any] = {
    "operations": [
        {"op": "set_positions", "robot": "arm", "positions": [0.0, -1.2, 1.9, -2.27, -1.57, 0.0]},
        {"op": "attach", "object": "can", "frame": "arm::tcp"},
        {"op": "allow", "pair": ["can", "table"]},
    ],
    "revision": 1,
}


class AddOperation(RequestModel):
    """Add an object."""

    model_config = ConfigDict(title="AddOperation")

    op: Literal["add"] = Field(description="Kind of the operation")
    object: ObjectDocument = Field(
        description="Object as in a scene document, with a name that is free"
    )

    def to_domain(self) -> domain.AddObject:
        """Return the operation for the domain."""
        return domain.AddObject(self.object.value())


class MoveOperation(RequestModel):
    """Put an object that is not attached elsewhere; frames that hang on it go along."""

    model_config = ConfigDict(title="MoveOperation")

    op: Literal["move"] = Field(description="Kind of the operation")
    object: Name = Field(description="Name of the object")
    pose: PoseDocument = Field(description="X_WO, its new pose in the world")

    def to_domain(self) -> domain.MoveObject:
        """Return the operation for the domain."""
        return domain.MoveObject(self.object, self.pose.value())


class RemoveOperation(RequestModel):
    """Remove an object, the frames that hang on it, and the pairs and margins that name it."""

    model_config = ConfigDict(title="RemoveOperation")

    op: Literal["remove"] = Field(description="Kind of the operation")
    object: Name = Field(description="Name of the object")

    def to_domain(self) -> domain.RemoveObject:
        """Return the operation for the domain."""
        return domain.RemoveObject(self.object)


class AttachOperation(RequestModel):
    """Let a robot hold an object: from now on it follows a frame and counts as the robot's body."""

    model_config = ConfigDict(title="AttachOperation")

    op: Literal["attach"] = Field(description="Kind of the operation")
    object: Name = Field(description="Name of the object; it must be `movable`")
    frame: Name = Field(description="`robot::link`, or a frame that hangs on one")
    touch: Annotated[list[Name], Field(max_length=1000)] | None = Field(
        default=None,
        description=(
            "Bodies that it may touch; by default those that move rigidly with the frame and those "
            "that they carry outside the robot's default group, such as fingers"
        ),
    )
    keep: Boolean = Field(
        default=True,
        description="Whether the object stays where it is in the world at the scene's positions",
    )
    pose: PoseDocument | None = Field(
        default=None,
        description="X_FO, pose of the object in the frame; required "
        "without `keep`, and not allowed with it",
    )
    grip: Annotated[GripDocument | None, ADDED] = Field(
        default=None,
        description="Contact that holds it in simulations; null for a weld",
    )

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if self.keep == (self.pose is not None):
            message = "give `keep: false` and a `pose` in the frame, or neither"
            raise ValueError(message)
        return self

    def to_domain(self) -> domain.AttachObject:
        """Return the operation for the domain."""
        touch = None if self.touch is None else tuple(self.touch)
        pose = None if self.pose is None else self.pose.value()
        grip = None if self.grip is None else self.grip.value()
        return domain.AttachObject(self.object, self.frame, touch, pose, grip)


class DetachOperation(RequestModel):
    """Leave an object where it is in the world at the scene's positions."""

    model_config = ConfigDict(title="DetachOperation")

    op: Literal["detach"] = Field(description="Kind of the operation")
    object: Name = Field(description="Name of the object")

    def to_domain(self) -> domain.DetachObject:
        """Return the operation for the domain."""
        return domain.DetachObject(self.object)


class SetPositionsOperation(RequestModel):
    """Put joints of a robot elsewhere; joints that are not named stay where they are."""

    model_config = ConfigDict(title="SetPositionsOperation")

    op: Literal["set_positions"] = Field(description="Kind of the operation")
    robot: Name = Field(description="Name of the robot in the scene")
    positions: Name | Positions | dict[Name, Coordinate | Positions] = Field(
        description=(
            "Name of a configuration, values of the default group, or values by joint [rad or m]"
        )
    )

    def to_domain(self) -> domain.SetPositions:
        """Return the operation for the domain."""
        match self.positions:
            case str() as name:
                return domain.SetPositions(self.robot, name)
            case list() as positions:
                return domain.SetPositions(self.robot, tuple(positions))
            case dict() as by_joint:
                placed: dict[str, float | tuple[float, ...]] = {
                    k: tuple(v) if isinstance(v, list) else v for k, v in by_joint.items()
                }
                return domain.SetPositions(self.robot, placed)


class AllowOperation(RequestModel):
    """Let two bodies touch."""

    model_config = ConfigDict(title="AllowOperation")

    op: Literal["allow"] = Field(description="Kind of the operation")
    pair: BodyNames = Field(description="Full names of the bodies")

    def to_domain(self) -> domain.AllowPair:
        """Return the operation for the domain."""
        return domain.AllowPair((self.pair[0], self.pair[1]))


class ForbidOperation(RequestModel):
    """No longer let two bodies touch, which the scene allowed."""

    model_config = ConfigDict(title="ForbidOperation")

    op: Literal["forbid"] = Field(description="Kind of the operation")
    pair: BodyNames = Field(description="Full names of the bodies")

    def to_domain(self) -> domain.ForbidPair:
        """Return the operation for the domain."""
        return domain.ForbidPair((self.pair[0], self.pair[1]))


type SceneOperation = Annotated[
    AddOperation
    | MoveOperation
    | RemoveOperation
    | AttachOperation
    | DetachOperation
    | SetPositionsOperation
    | AllowOperation
    | ForbidOperation,
    Field(discriminator="op", description="Operation on a scene, by `op`"),
]


class SceneEdit(RequestModel):
    """Operations, carried out in order; all of them or none."""

    model_config = ConfigDict(json_schema_extra={"examples": [EXAMPLE]})

    operations: Annotated[list[SceneOperation], Field(min_length=1, max_length=1000)] = Field(
        description="Operations, carried out in this order"
    )
    revision: Annotated[int, Strict(), Field(ge=1), WHOLE] | None = Field(
        default=None,
        description="The revision that they are meant for; by default the latest, whichever it is",
    )

    @property
    def placed_robots(self) -> list[str]:
        """The robots whose positions it sets."""
        return [each.robot for each in self.operations if isinstance(each, SetPositionsOperation)]
