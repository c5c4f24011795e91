"""Shapes of obstacles: boxes, spheres, cylinders, capsules, ellipsoids, half spaces, meshes [m]."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Box(Value):
    """Box with full side lengths [m], centred at the origin, shape (3,)."""

    size: Float64[np.ndarray, "3"]


@dataclass(frozen=True, eq=False)
class Sphere(Value):
    """Sphere centred at the origin."""

    radius: float


@dataclass(frozen=True, eq=False)
class Cylinder(Value):
    """Cylinder along z, centred at the origin."""

    radius: float
    length: float


@dataclass(frozen=True, eq=False)
class Capsule(Value):
    """Capsule along z, centred at the origin; `length` is that of the cylindrical part."""

    radius: float
    length: float


@dataclass(frozen=True, eq=False)
class Ellipsoid(Value):
    """Ellipsoid with semi-axes along x, y, z [m], shape (3,)."""

    semi_axes: Float64[np.ndarray, "3"]


@dataclass(frozen=True, eq=False)
class HalfSpace(Value):
    """Half space: all points with z <= 0 in the object's frame."""


@dataclass(frozen=True, eq=False)
class Convex(Value):
    """Convex hull of points [m], shape (n, 3)."""

    points: Float64[np.ndarray, "n 3"]


@dataclass(frozen=True, eq=False)
class Mesh(Value):
    """Mesh file; Drake takes its convex hull in every distance query.

    Attributes:
        uri: Path of an .obj, .vtk or .gltf file.
        scale: Factor per axis, shape (3,).
    """

    uri: str
    scale: Float64[np.ndarray, "3"]


type Shape = Box | Sphere | Cylinder | Capsule | Ellipsoid | HalfSpace | Convex | Mesh
