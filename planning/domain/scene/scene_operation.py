"""Scene operations: edits of a scene as values; `edit_scene` carries them out."""

from dataclasses import dataclass

from planning.domain.geometry.pose import Pose
from planning.domain.scene.grip import Grip
from planning.domain.scene.scene import SceneObject
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class AddObject(Value):
    """Scene operation: add an object under an unused name."""

    scene_object: SceneObject


@dataclass(frozen=True, eq=False)
class MoveObject(Value):
    """Scene operation: set an object's pose X_WO; frames with it as ancestor move along."""

    name: str
    pose: Pose


@dataclass(frozen=True, eq=False)
class RemoveObject(Value):
    """Scene operation: remove an object, the frames below it, and its collision settings."""

    name: str


@dataclass(frozen=True, eq=False)
class AttachObject(Value):
    """Scene operation: attach an object to a robot.

    Attributes:
        name: Of the object.
        frame: The frame F that it follows from now on.
        touch: Bodies that it may touch; None for the default of `Attachment`.
        pose: X_FO; None for its present pose.
        grip: Contact that holds the object; None for a weld.
    """

    name: str
    frame: str
    touch: tuple[str, ...] | None = None
    pose: Pose | None = None
    grip: Grip | None = None


@dataclass(frozen=True, eq=False)
class DetachObject(Value):
    """Scene operation: detach an object at its pose in the world at the scene's positions."""

    name: str


@dataclass(frozen=True, eq=False)
class SetPositions(Value):
    """Scene operation: set joint positions of a robot; joints that are not named keep theirs.

    Attributes:
        robot: Its name in the scene.
        positions: As in `SceneRobot`: a configuration's name, values of the default group, or
            values by joint.
    """

    robot: str
    positions: str | dict[str, float | tuple[float, ...]] | tuple[float, ...]


@dataclass(frozen=True, eq=False)
class AllowPair(Value):
    """Scene operation: allow two bodies to touch."""

    pair: tuple[str, str]


@dataclass(frozen=True, eq=False)
class ForbidPair(Value):
    """Scene operation: revoke the scene's permission for two bodies to touch."""

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
