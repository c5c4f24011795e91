"""hull_warnings(): meshes that are not convex, and by how much their hulls are larger."""

from functools import lru_cache
from pathlib import Path
from typing import Any

from pydrake.geometry import Convex, Mesh
from pydrake.multibody.tree import CalcSpatialInertia

from planning.world.drake_model import DrakeModel
from planning.world.mesh_files import twins_folder

# A hull that is larger by less is as good as the mesh.
_SMALLEST_EXCESS = 0.01


def hull_warnings(model: DrakeModel) -> tuple[str, ...]:
    """Return a warning for every body with a mesh that is checked as its larger convex hull."""
    inspector = model.scene_graph.model_inspector()
    found: list[str] = []
    for name, index in model.bodies.items():
        for geometry in model.plant.GetCollisionGeometriesForBody(model.plant.get_body(index)):
            shape = inspector.GetShape(geometry)
            if isinstance(shape, Mesh | Convex) and shape.source().is_path():
                path = Path(shape.source().path())
                excess = _excess(path, path.stat().st_mtime_ns)
                if excess is None:
                    text = "as its convex hull; it is not closed, so how much that adds is unknown"
                elif excess > _SMALLEST_EXCESS:
                    text = f"as its convex hull, which is {excess:.0%} larger"
                else:
                    continue
                is_twin = path.is_relative_to(twins_folder())
                mesh = inspector.GetName(geometry).rpartition("::")[2] if is_twin else path.name
                found.append(f"{name}: its mesh {mesh!r} is not convex and is checked {text}")
    return tuple(dict.fromkeys(found))


@lru_cache(maxsize=4096)
def _excess(path: Path, _changed: int) -> float | None:
    """Return the hull's volume over the mesh's, less 1; None if the mesh has no sure volume."""
    try:
        whole, hull = (_volume(kind(str(path))) for kind in (Mesh, Convex))
    except RuntimeError:  # inside out, flat or open
        return None
    return hull / whole - 1.0 if 0 < whole <= hull * (1 + 1e-6) else None


def _volume(shape: Any) -> float:
    return float(CalcSpatialInertia(shape, 1.0).get_mass())
