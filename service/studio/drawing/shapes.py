"""draw_shape(): a shape of the API's geometry as nodes of viser's scene."""

import io
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
import viser

# Of a plate that stands for a half space [m].
_PLATE_WIDTH, _PLATE_THICKNESS = 6.0, 0.01
# Subdivisions of an icosahedron: enough for meshes made here to look round.
_SUBDIVISIONS = 3


@dataclass(frozen=True)
class Paint:
    """How shapes are drawn.

    Attributes:
        color: Red, green, blue, 0 to 255; None for the shape's own.
        opacity: 0 to 1; None for the shape's own.
        grown: By how much each shape is larger than it is [m], so that it covers the true one.
        casts_shadow: Whether it does.
    """

    color: tuple[int, int, int] | None = None
    opacity: float | None = None
    grown: float = 0.0
    casts_shadow: bool = True


TRUE = Paint()


def draw_shape(
    scene: viser.SceneApi,
    path: str,
    shape: dict[str, Any],
    mesh: Callable[[str], bytes],
    paint: Paint = TRUE,
) -> None:
    """Add a shape to a scene.

    Args:
        scene: Of one browser.
        path: Its node.
        shape: `VisibleShape` of the API.
        mesh: Returns a mesh by its digest.
        paint: How to draw it.
    """
    own = [round(255 * part) for part in shape["color"]]
    alpha = shape["color"][3] if paint.opacity is None else paint.opacity
    look: dict[str, Any] = {
        "position": tuple(shape["pose"]["position"]),
        "wxyz": tuple(shape["pose"]["quaternion"]),
        "cast_shadow": paint.casts_shadow,
    }
    color = paint.color or (own[0], own[1], own[2])
    solid = {**look, "color": color, "opacity": None if alpha >= 1 else alpha}
    if shape["mesh"] is not None:
        _draw_mesh(scene, path, mesh(shape["mesh"]["sha256"]), paint, (look, solid))
        return
    _draw_primitive(scene, path, shape, paint.grown, solid)


def _draw_primitive(
    scene: viser.SceneApi, path: str, shape: dict[str, Any], grown: float, solid: dict[str, Any]
) -> None:
    if shape["box"] is not None:
        x, y, z = (side + 2 * grown for side in shape["box"])
        scene.add_box(path, dimensions=(x, y, z), **solid)
    elif shape["cylinder"] is not None:
        radius, length = shape["cylinder"]["radius"] + grown, shape["cylinder"]["length"]
        scene.add_cylinder(path, radius=radius, height=length + 2 * grown, **solid)
    elif shape["sphere"] is not None:
        radius = shape["sphere"] + grown
        scene.add_icosphere(path, radius=radius, subdivisions=_SUBDIVISIONS, **solid)
    elif shape["ellipsoid"] is not None:
        a, b, c = (axis + grown for axis in shape["ellipsoid"])
        scene.add_icosphere(path, 1.0, subdivisions=_SUBDIVISIONS, scale=(a, b, c), **solid)
    elif shape["capsule"] is not None:
        capsule = trimesh.creation.capsule(
            radius=shape["capsule"]["radius"] + grown, height=shape["capsule"]["length"]
        )
        # trimesh's begins at the origin or is centred, by version
        capsule.apply_translation(-capsule.bounds.mean(axis=0))
        scene.add_mesh_simple(path, np.array(capsule.vertices), np.array(capsule.faces), **solid)
    else:
        solid["position"] = _under(solid["position"], solid["wxyz"])
        size = (_PLATE_WIDTH, _PLATE_WIDTH, _PLATE_THICKNESS)
        scene.add_box(path, dimensions=size, **solid)


def _draw_mesh(
    scene: viser.SceneApi,
    path: str,
    content: bytes,
    paint: Paint,
    looks: tuple[dict[str, Any], dict[str, Any]],
) -> None:
    look, solid = looks
    loaded = trimesh.load_scene(io.BytesIO(content), file_type="glb")
    has_materials = any(
        getattr(part.visual, "material", None) is not None for part in loaded.geometry.values()
    )
    if paint is TRUE and has_materials:
        scene.add_glb(path, content, **look)
        return
    whole = loaded.to_mesh()
    if paint.grown:
        whole.vertices = whole.vertices + paint.grown * whole.vertex_normals
    scene.add_mesh_simple(path, np.array(whole.vertices), np.array(whole.faces), **solid)


def _under(position: tuple[float, ...], wxyz: tuple[float, ...]) -> tuple[float, ...]:
    """Return the middle of a plate whose top is the plane of a half space at a pose."""
    up = trimesh.transformations.quaternion_matrix(wxyz)[:3, 2]
    return tuple(np.array(position) - _PLATE_THICKNESS / 2 * up)
