"""SceneDocument: pydantic model of a scene file."""

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    ConfigDict,
    Field,
    StringConstraints,
    model_validator,
)

from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import HalfSpace
from planning.domain.scene.grip import Grip
from planning.domain.scene.scene import (
    Attachment,
    NamedConfiguration,
    NamedGroup,
    PairMargin,
    Scene,
    SceneFrame,
    SceneObject,
    SceneRobot,
)
from planning.world.documents.shape_document import ShapeDocument
from planning.world.documents.strict_model import (
    Boolean,
    Distance,
    Number,
    Positive,
    StrictModel,
    Unit,
)

type Name = Annotated[
    str, StringConstraints(min_length=1, max_length=128, pattern=r"^[A-Za-z0-9_.\-]+$")
]
type Path_ = Annotated[
    str, StringConstraints(min_length=1, max_length=256, pattern=r"^[A-Za-z0-9_.:\-]+$")
]
# Of several groups the names are joined by `+`.
type GroupPath = Annotated[
    str, StringConstraints(min_length=1, max_length=1024, pattern=r"^[A-Za-z0-9_.:\-+]+$")
]
type Triple = Annotated[list[Number], Field(min_length=3, max_length=3)]
type Quadruple = Annotated[list[Number], Field(min_length=4, max_length=4)]


class PoseDocument(StrictModel):
    """A rigid transform; `quaternion` or `rpy`, or neither for no rotation."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"position": [0.5, 0.0, 0.2], "rpy": [0.0, 0.0, 1.57]}]}
    )

    position: Triple = Field(default=[0.0, 0.0, 0.0], description="x, y, z [m]")
    quaternion: Quadruple | None = Field(default=None, description="[w, x, y, z], any length > 0")
    rpy: Triple | None = Field(default=None, description="roll, pitch, yaw about fixed axes [rad]")

    @model_validator(mode="after")
    def _check_rotation(self) -> "PoseDocument":
        if self.quaternion is not None and self.rpy is not None:
            message = "give `quaternion` or `rpy`, not both"
            raise ValueError(message)
        if self.quaternion is not None and not np.linalg.norm(self.quaternion) > 1e-9:
            message = "quaternion [w, x, y, z] must not be zero"
            raise ValueError(message)
        return self

    def value(self) -> Pose:
        """Return the domain's pose."""
        return Pose.from_parts(self.position, self.quaternion, self.rpy)


class RobotDocument(StrictModel):
    """A robot in the scene."""

    name: Name = Field(description="Prefix of its bodies, frames and joints: `name::link`")
    model: Annotated[str, StringConstraints(min_length=1, max_length=1024)] = Field(
        description="Name of a robot (GET /v1/models), or a path of a URDF, SDF or MJCF file"
    )
    base: PoseDocument = Field(
        default_factory=PoseDocument, description="X_WB, pose at which its base link is welded"
    )
    positions: Name | list[Number] | dict[str, Number | list[Number]] | None = Field(
        default=None,
        description="Name of a configuration, values of its default group, or values by joint",
    )
    weld: Boolean | None = Field(
        default=None,
        description="Whether its base link is welded to the world at `base`, or floats "
        "and starts there. By default bases of URDF files are welded, and "
        "those of SDF and MJCF files float unless they say otherwise "
        "themselves",
    )

    def value(self) -> SceneRobot:
        """Return the domain's robot."""
        positions: Any = self.positions
        if isinstance(positions, list):
            positions = tuple(positions)
        elif isinstance(positions, dict):
            positions = {k: tuple(v) if isinstance(v, list) else v for k, v in positions.items()}
        return SceneRobot(self.name, self.model, self.base.value(), positions, self.weld)


class GripDocument(StrictModel):
    """Contact by which a gripper holds an object: friction, and nothing else."""

    gripper: Path_ = Field(description="Group that is a gripper, `robot::group`")
    force: Annotated[Positive, Field(le=1e5)] = Field(
        description="Force that presses each finger on the object [N]"
    )
    friction: Annotated[Positive, Field(le=10)] = Field(
        default=0.5,
        description="Coefficient of Coulomb friction a of the object; that of a contact is "
        "2ab / (a + b), where the b of the finger is 1 unless its description says otherwise",
    )
    slip: Annotated[Distance, Field(gt=0, le=1)] = Field(
        default=0.005,
        description="Largest distance by which the object may move in the gripper before it counts "
        "as lost [m]",
    )

    def value(self) -> Grip:
        """Return the domain's grip."""
        return Grip(self.gripper, self.force, self.friction, self.slip)


class AttachmentDocument(StrictModel):
    """Attachment of an object to a robot."""

    frame: Path_ = Field(
        description="Frame that the object follows: `robot::link`, or a frame with one as ancestor"
    )
    touch: Annotated[list[Path_], Field(max_length=1000)] | None = Field(
        default=None,
        description=(
            "Bodies that it may touch; by default those that move rigidly with the frame and those "
            "that they carry outside the robot's default group, such as fingers"
        ),
    )

    grip: GripDocument | None = Field(
        default=None,
        description="Contact that holds it; none for a weld. Plans and proofs take it to be welded "
        "either way, and a simulated robot may lose what is held by contact",
    )

    def value(self) -> Attachment:
        """Return the domain's attachment."""
        touch = None if self.touch is None else tuple(self.touch)
        return Attachment(self.frame, touch, None if self.grip is None else self.grip.value())


class ObjectDocument(StrictModel):
    """An obstacle, or an object to handle."""

    name: Name = Field(description="Name of its body and of its frame")
    shape: ShapeDocument = Field(description="Geometry of the object [m]")
    pose: PoseDocument = Field(
        default_factory=PoseDocument, description="X_WO; of an attached object X_FO, in its frame"
    )
    movable: Boolean = Field(default=False, description="Whether it may be attached")
    color: list[Unit] | None = Field(
        default=None, min_length=3, max_length=4, description="RGB or RGBA, each 0 to 1"
    )
    attached: AttachmentDocument | None = Field(
        default=None, description="Its attachment to a robot; none if it is fixed to the world"
    )
    mass: Positive | None = Field(
        default=None,
        description="Its mass while it is attached [kg]; none for no mass. Its inertia is that of "
        "the shape at uniform density; a mesh counts as its convex hull",
    )
    center_of_mass: Triple | None = Field(
        default=None,
        description="Center of mass in its frame [m]; none for that of the shape; only with `mass`",
    )

    @model_validator(mode="after")
    def _check_mass(self) -> "ObjectDocument":
        if self.center_of_mass is not None and self.mass is None:
            message = "`center_of_mass` needs a `mass`"
            raise ValueError(message)
        if self.mass is not None and isinstance(self.shape.value(), HalfSpace):
            message = "a half space cannot have a `mass`: its volume is infinite"
            raise ValueError(message)
        return self

    def value(self) -> SceneObject:
        """Return the domain's object."""
        return SceneObject(
            name=self.name,
            shape=self.shape.value(),
            pose=self.pose.value(),
            movable=self.movable,
            color=None if self.color is None else np.array([*self.color, 1.0][:4]),
            attached=None if self.attached is None else self.attached.value(),
            mass=self.mass,
            center_of_mass=None if self.center_of_mass is None else np.array(self.center_of_mass),
        )


class FrameDocument(StrictModel):
    """A named pose: a target, a tool point."""

    name: Name = Field(description="Name of the frame")
    parent: Path_ = Field(
        default="world",
        description="Parent of the frame: an object, a frame, `robot::link` or `world`",
    )
    pose: PoseDocument = Field(
        default_factory=PoseDocument, description="X_PF, pose of the frame in its parent"
    )

    def value(self) -> SceneFrame:
        """Return the domain's frame."""
        return SceneFrame(self.name, self.parent, self.pose.value())


class ConfigurationDocument(StrictModel):
    """A named configuration of a group."""

    group: GroupPath = Field(description="`robot`, `robot::group`, or a group of `groups`")
    positions: list[Number] = Field(
        description="Positions in the group's order [rad or m]", min_length=1
    )


class MarginDocument(StrictModel):
    """A distance that two bodies keep, other than the scene's margin."""

    bodies: Annotated[list[Path_], Field(min_length=2, max_length=2)]
    margin: Distance = Field(description="Distance that they keep [m]")


type BodyPairDocument = Annotated[list[Path_], Field(min_length=2, max_length=2)]


class SceneDocument(StrictModel):
    """A scene: robots, obstacles, frames."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "name": "table_top",
                    "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}],
                    "objects": [
                        {
                            "name": "table",
                            "shape": {"box": [1.2, 0.8, 0.05]},
                            "pose": {"position": [0.5, 0, -0.03]},
                        }
                    ],
                    "frames": [
                        {"name": "pick", "parent": "table", "pose": {"position": [0, 0.2, 0.2]}}
                    ],
                    "allowed_collisions": [["table", "arm::base_link"]],
                    "margin": 0.0,
                }
            ]
        }
    )

    version: Literal[1] = Field(default=1, description="Version of this format")
    name: Name = Field(default="scene", description="Name for people")
    robots: list[RobotDocument] = Field(min_length=1, max_length=64)
    objects: list[ObjectDocument] = Field(default=[], max_length=10_000)
    frames: list[FrameDocument] = Field(default=[], max_length=10_000)
    allowed_collisions: list[BodyPairDocument] = Field(
        default=[], max_length=100_000, description="Pairs of bodies that may touch"
    )
    groups: dict[Name, Annotated[list[Path_], Field(min_length=1, max_length=64)]] = Field(
        default={},
        description="Groups that span groups of robots, `robot` or `robot::group` each, in order",
    )
    configurations: dict[Name, ConfigurationDocument] = Field(
        default={}, description="Named configurations beside those of the robots"
    )
    margin: Distance = Field(
        default=0.0, description="Distance kept from everything but the robot itself [m]"
    )
    margins: list[MarginDocument] = Field(
        default=[], max_length=100_000, description="Exceptions from `margin`, by pair"
    )

    def value(self) -> Scene:
        """Return the domain's scene."""
        return Scene(
            name=self.name,
            robots=tuple(robot.value() for robot in self.robots),
            objects=tuple(thing.value() for thing in self.objects),
            frames=tuple(frame.value() for frame in self.frames),
            allowed_collisions=tuple((a, b) for a, b in self.allowed_collisions),
            configurations=tuple(
                NamedConfiguration(name, entry.group, np.array(entry.positions, dtype=np.float64))
                for name, entry in self.configurations.items()
            ),
            margin=self.margin,
            margins=tuple(
                PairMargin((entry.bodies[0], entry.bodies[1]), entry.margin)
                for entry in self.margins
            ),
            groups=tuple(NamedGroup(name, tuple(m)) for name, m in self.groups.items()),
        )
