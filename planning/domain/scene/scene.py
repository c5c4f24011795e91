"""Scene: robots, objects, frames and margins as values; `World` is a scene loaded into Drake."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import Shape
from planning.domain.scene.grip import Grip
from planning.domain.scene.kept_files import KeptFiles
from planning.domain.value import Value, digest


@dataclass(frozen=True, eq=False)
class SceneRobot(Value):
    """Robot in a scene.

    Attributes:
        name: Prefix of the full names of its parts: `name::link`.
        model: Name of a bundled robot, or the path of a URDF, SDF or MJCF file.
        base: X_WB, pose to which its base link is welded.
        positions: Name of a configuration, or values by joint name, or a list of values for its
            default group; None for the configuration `home`, or zeros within limits.
        weld: Whether its base link is welded to the world; None where its description decides:
            bases of URDF files are welded, those of SDF and MJCF files float unless they say
            otherwise. A base that is not welded starts at `base`.
    """

    name: str
    model: str
    base: Pose
    positions: str | dict[str, float | tuple[float, ...]] | tuple[float, ...] | None
    weld: bool | None = None


@dataclass(frozen=True, eq=False)
class Attachment(Value):
    """Attachment of an object to a robot.

    Attributes:
        frame: The frame F that the object follows: a robot's, or one with a robot's as ancestor.
        touch: Bodies that it may touch; None for those that move rigidly with F and those that
            they carry on joints outside the robot's default group, such as fingers.
        grip: Contact that holds the object; None for a weld.
    """

    frame: str
    touch: tuple[str, ...] | None = None
    grip: Grip | None = None


@dataclass(frozen=True, eq=False)
class SceneObject(Value):
    """Object in a scene: an obstacle or a movable object.

    Attributes:
        name: Of its body and of its frame.
        shape: Its geometry.
        pose: X_WO; of an attached object X_FO.
        movable: Whether it may be attached.
        color: RGBA in 0..1, or None for a default, shape (4,).
        attached: Its attachment to a robot; None for an object that is fixed to the world.
        mass: Its mass while it is attached [kg]; None for none.
        center_of_mass: In its frame [m], None for that of the shape, shape (3,).
    """

    name: str
    shape: Shape
    pose: Pose
    movable: bool = False
    color: Float64[np.ndarray, "4"] | None = None
    attached: Attachment | None = None
    mass: float | None = None
    center_of_mass: Float64[np.ndarray, "3"] | None = None

    caches_bytes = True


@dataclass(frozen=True, eq=False)
class SceneFrame(Value):
    """Named frame in a scene.

    Attributes:
        name: Its name.
        parent: An object, a frame, `robot::link` or "world".
        pose: X_PF.
    """

    name: str
    parent: str
    pose: Pose

    caches_bytes = True


@dataclass(frozen=True, eq=False)
class NamedConfiguration(Value):
    """Named configuration of a group.

    Attributes:
        name: Its name.
        group: The group's name.
        positions: The group's q, shape (nq,).
    """

    name: str
    group: str
    positions: Float64[np.ndarray, " nq"]


@dataclass(frozen=True, eq=False)
class NamedGroup(Value):
    """Named group that spans groups of robots.

    Attributes:
        name: Its name; no robot has it.
        members: `robot` or `robot::group` each, at least one; joints are in this order.
    """

    name: str
    members: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class PairMargin(Value):
    """Collision margin of two bodies, other than the scene's.

    Attributes:
        bodies: Full names.
        margin: Distance to keep [m].
    """

    bodies: tuple[str, str]
    margin: float


@dataclass(frozen=True, eq=False)
class Scene(Value):
    """Scene document as values, validated.

    Attributes:
        name: For people.
        robots: In order; at least one.
        objects: In order.
        frames: In order; a frame's parent may be defined later.
        allowed_collisions: Pairs of bodies that may touch.
        configurations: Named configurations beside those of the robots.
        margin: Collision margin of all pairs of bodies [m].
        margins: Exceptions, by pair.
        files: Files of robots and meshes by content, by the name of the robot or object. For those
            missing here, `load_world` reads the files from disk and adds them to the `scene` of the
            world; for those given here, nothing else is read.
        groups: Groups that span groups of robots; without any, the digest is that of older scenes.
    """

    left_out_if_empty = frozenset({"groups"})

    name: str
    robots: tuple[SceneRobot, ...]
    objects: tuple[SceneObject, ...] = ()
    frames: tuple[SceneFrame, ...] = ()
    allowed_collisions: tuple[tuple[str, str], ...] = ()
    configurations: tuple[NamedConfiguration, ...] = ()
    margin: float = 0.0
    margins: tuple[PairMargin, ...] = ()
    files: Mapping[str, KeptFiles] = field(default_factory=dict)
    groups: tuple[NamedGroup, ...] = ()

    @property
    def digest(self) -> str:
        """sha256 of the content; of the bytes of files only where `files` has them."""
        return digest(self)
