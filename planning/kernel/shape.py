"""ConvexShape: convex collision geometry as the kernel's input."""

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value


class ShapeKind(StrEnum):
    """Kinds of shapes that the kernel has exactly: the members of its ShapeKind (kinds.hpp)."""

    BOX = "box"
    SPHERE = "sphere"
    CYLINDER = "cylinder"
    CAPSULE = "capsule"
    ELLIPSOID = "ellipsoid"
    HULL = "hull"
    HALF_SPACE = "half_space"


@dataclass(frozen=True, eq=False)
class ConvexShape(Value):
    """Convex body in its own frame G.

    Attributes:
        kind: Its kind; the axis of cylinders and capsules is z, a half space is z <= 0.
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

    @property
    def ball(self) -> tuple[Float64[np.ndarray, "3"], float]:
        """Bounding ball: the centre in G [m], shape (3,), and the radius [m]."""
        size = self.size
        match self.kind:
            case ShapeKind.HULL:
                center = (self.vertices.min(axis=0) + self.vertices.max(axis=0)) / 2
                return center, float(np.linalg.norm(self.vertices - center, axis=1).max())
            case ShapeKind.HALF_SPACE:
                return np.zeros(3), np.inf
            case ShapeKind.CAPSULE:
                return np.zeros(3), float(size[0] + size[1])
            case ShapeKind.ELLIPSOID:
                return np.zeros(3), float(size.max())
            case ShapeKind.BOX | ShapeKind.SPHERE | ShapeKind.CYLINDER:
                return np.zeros(3), math.hypot(*size.tolist())
