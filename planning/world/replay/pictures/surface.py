"""Surface: triangles with normals and colours, of shapes and of meshes."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.geometry.shapes import Box, Capsule, Cylinder, Ellipsoid, Sphere
from planning.domain.scene.geometry import MeshFile, VisibleBody, VisibleShape
from planning.domain.value import Value

# Parts of a circle, and subdivisions of an icosahedron.
_SECTIONS, _SUBDIVISIONS = 64, 4
# Neighbouring faces at a smaller angle than this look like one bent surface.
_COS_CREASE = np.cos(np.deg2rad(40.0))
# A plate in place of a half space: its side [m], and squares along it, so that some are in sight.
_PLATE, _SQUARES = 8.0, 64


@dataclass(frozen=True, eq=False)
class Surface(Value):
    """Triangles in one frame.

    Attributes:
        corners: Shape (n, 3, 3) [m].
        normals: At the corners, of length 1, shape (n, 3, 3).
        colors: Red, green, blue and opacity of the triangles, 0 to 1, shape (n, 4).
    """

    corners: Float64[np.ndarray, "n 3 3"]
    normals: Float64[np.ndarray, "n 3 3"]
    colors: Float64[np.ndarray, "n 4"]

    def placed(self, pose: Float64[np.ndarray, "4 4"]) -> "Surface":
        """Return it in the frame A of a pose X_AS."""
        turn, shift = pose[:3, :3], pose[:3, 3]
        return Surface(self.corners @ turn.T + shift, self.normals @ turn.T, self.colors)

    def painted(self, color: Sequence[float]) -> "Surface":
        """Return it in one colour, red, green, blue and opacity."""
        return Surface(self.corners, self.normals, np.tile(color, (len(self.corners), 1)))


def joined(surfaces: Sequence[Surface]) -> Surface:
    """Return surfaces of one frame as one."""
    if not surfaces:
        return Surface(np.empty((0, 3, 3)), np.empty((0, 3, 3)), np.empty((0, 4)))
    parts = [(one.corners, one.normals, one.colors) for one in surfaces]
    return Surface(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def surface_of(body: VisibleBody, meshes: Mapping[str, bytes]) -> Surface:
    """Return a body's surface in its own frame B.

    Args:
        body: What it looks like.
        meshes: Binary glTF files by sha256, of all that it names.
    """
    found = [
        one.placed(shape.X_BS.matrix) for shape in body.shapes for one in _surfaces(shape, meshes)
    ]
    return joined(found)


def tube(
    points: Float64[np.ndarray, "n 3"], colors: Float64[np.ndarray, "n 3"], radius: float
) -> Surface:
    """Return a line through points as something round.

    Args:
        points: n >= 2 [m].
        colors: At the points, red, green, blue.
        radius: [m].
    """
    import trimesh  # noqa: PLC0415  (takes longer than Drake, and few ask for pictures)

    parts: list[Surface] = []
    for i in range(len(points) - 1):
        if np.linalg.norm(points[i + 1] - points[i]) > 1e-6:
            piece = trimesh.creation.cylinder(radius, segment=points[i : i + 2], sections=8)
            parts.append(_smooth(piece, [*(colors[i] + colors[i + 1]) / 2, 1.0]))
    return joined(parts)


def _surfaces(shape: VisibleShape, meshes: Mapping[str, bytes]) -> list[Surface]:
    import trimesh  # noqa: PLC0415

    if isinstance(shape.shape, MeshFile):
        scene: Any = trimesh.load_scene(io.BytesIO(meshes[shape.shape.sha256]), file_type="glb")
        return [_smooth(mesh, _own_color(mesh, shape.color)) for mesh in scene.dump()]
    return [_smooth(_primitive(shape.shape), shape.color)]


def _primitive(shape: Any) -> Any:
    from trimesh import creation  # noqa: PLC0415

    match shape:
        case Box():
            return creation.box(shape.size)
        case Sphere():
            return creation.icosphere(_SUBDIVISIONS, shape.radius)
        case Cylinder():
            return creation.cylinder(shape.radius, shape.length, sections=_SECTIONS)
        case Capsule():
            count = [_SECTIONS, _SECTIONS // 2]
            capsule = creation.capsule(shape.length, shape.radius, count=count)
            return capsule.apply_translation(-capsule.bounds.mean(axis=0))
        case Ellipsoid():
            return creation.icosphere(_SUBDIVISIONS, 1.0).apply_scale(shape.semi_axes)
        case _:
            return _plate()


def _plate() -> Any:
    """Return the plane z = 0 around the origin as many squares."""
    import trimesh  # noqa: PLC0415

    ticks = np.linspace(-_PLATE / 2, _PLATE / 2, _SQUARES + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(ticks, ticks))
    i, j = (axis.ravel() for axis in np.indices((_SQUARES, _SQUARES)))
    first = i * (_SQUARES + 1) + j
    above = first + _SQUARES + 1
    faces = np.concatenate([
        np.stack([first, first + 1, above], axis=1),
        np.stack([first + 1, above + 1, above], axis=1),
    ])
    return trimesh.Trimesh(np.stack([x, y, np.zeros_like(x)], axis=1), faces, process=False)


def _own_color(mesh: Any, color: Array) -> Array:
    """Return the colour of a mesh's material, else that of the shape."""
    material = getattr(mesh.visual, "material", None)
    own = getattr(material, "main_color", None)
    if material is None or own is None or material.name == "default":
        return color
    return np.array(own[:4], dtype=float) / 255


def _smooth(mesh: Any, color: Any) -> Surface:
    """Return a mesh with normals of its vertices, but where it has an edge of its faces."""
    corners = np.array(mesh.triangles, dtype=float)
    flat = np.array(mesh.face_normals, dtype=float)[:, None].repeat(3, axis=1)
    round_ = np.array(mesh.vertex_normals, dtype=float)[mesh.faces]
    is_crease = np.einsum("nkd,nkd->nk", flat, round_) < _COS_CREASE
    normals = np.where(is_crease[..., None], flat, round_)
    return Surface(corners, normals, np.tile(color, (len(corners), 1)).astype(float))
