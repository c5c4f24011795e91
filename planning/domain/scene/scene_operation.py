"""Operations on scenes, as values; `edit_scene` carries them out."""

from dataclasses import dataclass

from planning.domain.geometry.pose import Pose
from planning.domain.scene.scene import SceneObject
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class AddObject(Value):
    """Add an object under a name that is free."""

    thing: SceneObject


@dataclass(frozen=True, eq=False)
class MoveObject(Value):
    """Put an object elsewhere in the world, X_WO; frames that hang on it go along."""

    name: str
    pose: Pose


@dataclass(frozen=True, eq=False)
class RemoveObject(Value):
    """Remove an object, the frames that hang on it, and what the scene says of its collisions."""

    name: str


@dataclass(frozen=True, eq=False)
class AttachObject(Value):
    """Let a robot hold an object.

    Attributes:
        name: Of the object.
        frame: The frame F that it follows from now on.
        touch: Bodies that it may touch; None for the default of `Attachment`.
        pose: X_FO; None for where it is now.
    """

    name: str
    frame: str
    touch: tuple[str, ...] | None = None
    pose: Pose | None = None


@dataclass(frozen=True, eq=False)
class DetachObject(Value):
    """Leave an object where it is in the world at the scene's positions."""

    name: str


@dataclass(frozen=True, eq=False)
class SetPositions(Value):
    """Put joints of a robot elsewhere; joints that are not named stay where they are.

    Attributes:
        robot: Its name in the scene.
        positions: As in `SceneRobot`: a configuration's name, values of the default group, or
            values by joint.
    """

    robot: str
    positions: str | dict[str, float | tuple[float, ...]] | tuple[float, ...]


@dataclass(frozen=True, eq=False)
class AllowPair(Value):
    """Let two bodies touch."""

    pair: tuple[str, str]


@dataclass(frozen=True, eq=False)
class ForbidPair(Value):
    """No longer let two bodies touch, which the scene allowed."""

    pair: tuple[str, str]


type SceneOperation = (
    AddObject
    | MoveObject
    | RemoveObject
    | AttachObject
    | DetachObject
    | SetPositions
    | AllowPair
    | ForbidPair
)
