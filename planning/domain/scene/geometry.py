"""SceneGeometry: what the bodies of a scene look like."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Sphere,
)
from planning.domain.value import Value


@dataclass(frozen=True)
class MeshFile:
    """Triangles in a file of their own: glTF 2.0, binary, in metres, with z up.

    Attributes:
        sha256: Of its bytes.
    """

    sha256: str


@dataclass(frozen=True, eq=False)
class VisibleShape(Value):
    """Shape of a body that is drawn.

    Attributes:
        shape: Geometric primitive, or a mesh.
        X_BS: Its pose on its body.
        color: Red, green, blue and opacity, 0 to 1, shape (4,); meshes may have their own.
    """

    shape: Box | Sphere | Cylinder | Capsule | Ellipsoid | HalfSpace | MeshFile
    X_BS: Pose
    color: Float64[np.ndarray, "4"]


@dataclass(frozen=True)
class VisibleBody:
    """Body that is drawn.

    Attributes:
        name: Full name, which is also that of its frame.
        X_WB: Its pose, where it is fixed to the world; None for what moves with a robot.
        shapes: Its visual shapes; its collision shapes if it has none.
    """

    name: str
    X_WB: Pose | None
    shapes: tuple[VisibleShape, ...]


@dataclass(frozen=True, eq=False)
class SceneMotion(Value):
    """A scene at the instants of a motion: what its bodies look like, and where each one is.

    Attributes:
        bodies: All visible bodies.
        fixed: X_WF of bodies and named frames that stand still, by name.
        moving: X_WF of those that move, by name, shape (n, 4, 4): one per instant.
        tool_path: Origin of the group's default tool frame [m], shape (n, 3); no row without one.
        meshes: Binary glTF files by sha256, of all that the bodies name.
    """

    bodies: tuple[VisibleBody, ...]
    fixed: dict[str, Pose]
    moving: dict[str, Float64[np.ndarray, "n 4 4"]]
    tool_path: Float64[np.ndarray, "k 3"]
    meshes: dict[str, bytes]
