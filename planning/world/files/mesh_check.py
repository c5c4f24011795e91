"""validate_mesh(): validation of a mesh file before a C++ parser reads it."""

from functools import lru_cache
from pathlib import Path

from planning.errors import ModelInvalid
from planning.world.files.gltf_file import validate_gltf
from planning.world.files.obj_file import validate_obj
from planning.world.files.vtk_file import validate_vtk

_VALIDATORS = {".gltf": validate_gltf, ".obj": validate_obj, ".vtk": validate_vtk}


def validate_mesh(mesh: Path, named: str) -> None:
    """Raise if a mesh refers to elements that it does not have; unknown kinds pass.

    Args:
        mesh: The file.
        named: Name of the referring file, for the message.

    Raises:
        ModelInvalid: An element does not exist; the message names the file and the element.
    """
    status = mesh.stat()
    fault = _fault(mesh, status.st_mtime_ns, status.st_size)
    if fault:
        reason = f"mesh {mesh.name}: {fault}"
        raise ModelInvalid(f"{named}: {reason}", {"file": str(mesh), "reason": reason})


@lru_cache(maxsize=1024)
def _fault(mesh: Path, _time: int, _size: int) -> str:
    """Return the fault of a mesh, or ""; cached, since stored copies never change."""
    validate = _VALIDATORS.get(mesh.suffix.lower())
    try:
        if validate is not None:
            validate(mesh)
    except ValueError as fault:
        return str(fault)
    return ""
