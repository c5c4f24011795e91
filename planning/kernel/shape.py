"""ConvexShape: collision geometry as the kernel takes it."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value


class ShapeKind(StrEnum):
    """What the kernel knows exactly."""

    BOX = "box"
    SPHERE = "sphere"
    CYLINDER = "cylinder"
    CAPSULE = "capsule"
    ELLIPSOID = "ellipsoid"
    HULL = "hull"
    HALF_SPACE = "half_space"


@dataclass(frozen=True, eq=False)
class ConvexShape(Value):
    """A convex body in its own frame G.

    Attributes:
        kind: What it is; the axis of cylinders and capsules is z, a half space is z <= 0.
        size: Box: half side lengths. Sphere: (r, 0, 0). Cylinder and capsule: (r, half length of
            the cylindrical part, 0). Ellipsoid: semi-axes. Else zeros. [m], shape (3,).
        vertices: Of a hull [m], shape (k, 3); else (0, 3).
        planes: Faces of a hull as rows (n, d): unit outward normal n, and n . x <= d [m] inside,
            shape (f, 4); else (0, 4).
    """

    kind: ShapeKind
    size: Float64[np.ndarray, "3"]
    vertices: Float64[np.ndarray, "k 3"]
    planes: Float64[np.ndarray, "f 4"]
