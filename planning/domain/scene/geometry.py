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
