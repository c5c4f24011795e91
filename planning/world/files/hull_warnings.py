"""hull_warnings(): warnings about meshes that are not convex, with their hulls' excess volume."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.geometry import Convex, Mesh
from pydrake.multibody.tree import CalcSpatialInertia

from planning.world.drake_model import DrakeModel
from planning.world.files.mesh_files import source_name

# Relative excess volume below which a mesh counts as convex.
_MIN_EXCESS = 0.01


def hull_warnings(model: DrakeModel) -> tuple[str, ...]:
    """Return a warning for every body with a mesh that is checked as its larger convex hull."""
    inspector = model.scene_graph.model_inspector()
    shapes = [
        (name, inspector.GetShape(geometry))
        for name, index in model.bodies.items()
        for geometry in model.plant.GetCollisionGeometriesForBody(model.plant.get_body(index))
    ]
    static_objects = model.static_objects
    shapes += [
        (static_objects.objects[row].name, static_objects.drake_shapes[row])
        for row in static_objects.meshes
    ]
    found: list[str] = []
    for name, shape in shapes:
        if isinstance(shape, Mesh | Convex) and shape.source().is_path():
            path, scale = Path(shape.source().path()), np.asarray(shape.scale3()).tolist()
            text = _warning(path, tuple(scale), path.stat().st_mtime_ns)
            found += [f"{name}: {text}"] if text else []
    return tuple(dict.fromkeys(found))


@lru_cache(maxsize=4096)
def _warning(path: Path, scale: tuple[float, ...], _changed: int) -> str:
    """Return the excess volume of a mesh's hull as text; "" if the mesh is convex enough."""
    mesh = Mesh(str(path), scale3=np.array(scale))
    hull: Any = mesh.GetConvexHull()
    # The divergence theorem: a third of the flow of x through the faces.
    hull_volume = sum(
        hull.area(i) * (hull.face_normal(i) @ hull.element_centroid(i)) / 3.0
        for i in range(hull.num_faces())
    )
    volume = _volume(mesh)
    text = f"its mesh {source_name(path)!r} is checked as its convex hull, "
    if not 0 < volume <= hull_volume * (1 + _MIN_EXCESS):
        return text + "and its volume is not well defined, so the added volume is unknown"
    excess = hull_volume / volume - 1.0
    return text + f"which is {excess:.0%} larger" if excess > _MIN_EXCESS else ""


def _volume(mesh: Mesh) -> float:
    """Return the volume inside a mesh [m^3]; 0 if it is not well defined."""
    try:
        return float(CalcSpatialInertia(mesh, 1.0).get_mass())
    except (RuntimeError, ValueError):  # inside out, flat or open
        return 0.0
