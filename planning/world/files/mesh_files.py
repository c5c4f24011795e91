"""Mesh conversion: STL, COLLADA and PLY, which Drake does not read, become cached OBJ files."""

import hashlib
import os
import re
from copy import deepcopy
from importlib.metadata import version
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from planning.errors import ModelInvalid
from planning.parallel.atomic_files import evict_oldest, write_atomically
from planning.world.files.mesh_axes import to_z_up

_READ_BY_DRAKE = (".obj", ".vtk", ".gltf")
_READ_BY_DRAKE_IN_MJCF = (".obj",)
_CONVERTED = (".stl", ".dae", ".ply", ".off", ".glb")
# Version of the conversion, raised with every change of it: other versions' files are not read.
_VERSION = 2
_CONVERTED_NAME = re.compile(r"^[0-9a-f]{64}-(.*)\.obj$")
# Size of the cache [bytes], and age above which a file may be removed [s]: loaded worlds touch
# theirs when they load, and may read them again for a replay.
_MAX_BYTES, _MIN_AGE = 2**29, 3600.0
_MAX_NAME_LENGTH = 100


def with_readable_meshes(
    file: Path, root: ET.Element, meshes: dict[str, Path], folder: Path, *, always: bool = False
) -> str | None:
    """Return the description with every mesh replaced by the address of one that Drake reads.

    Addresses are file:// ones, and in MJCF paths. None if Drake reads all of them as they are.

    Args:
        file: The description.
        root: The description, parsed; left as it is.
        meshes: Path of each mesh, by its name in the description.
        folder: Of converted meshes.
        always: Return the description even if Drake reads all of its meshes.

    Raises:
        ModelInvalid: A mesh is of an unknown kind, or is broken.
    """
    is_mjcf = root.tag == "mujoco"
    readable_suffixes = _READ_BY_DRAKE_IN_MJCF if is_mjcf else _READ_BY_DRAKE
    if not always and all(path.suffix.lower() in readable_suffixes for path in meshes.values()):
        return None
    readable = {
        name: _readable(file, path, readable_suffixes, folder) for name, path in meshes.items()
    }
    paths = {name: str(twin) if is_mjcf else twin.as_uri() for name, twin in readable.items()}
    copy = deepcopy(root)
    for element in copy.iter():
        if is_mjcf and element.tag == "mesh" and element.get("file") and not element.get("name"):
            element.set("name", Path(element.get("file", "")).stem)  # as MuJoCo does
        for attribute in ("filename", "file"):
            if element.get(attribute) in paths:
                element.set(attribute, paths[element.get(attribute, "")])
        if element.tag == "uri" and (element.text or "").strip() in paths:
            element.text = paths[(element.text or "").strip()]
    _repair_colors(copy)
    for transmission in copy.findall("transmission"):
        copy.remove(transmission)  # unused here, and fatal to Drake if its joint does not exist
    return ET.tostring(copy, encoding="unicode")


def _repair_colors(root: ET.Element) -> None:
    """Repair colours that other viewers accept and Drake rejects, rather than refuse the robot.

    A material's name that is given twice with different colours gets a number, and a colour of five
    numbers, as one converter writes, loses the fourth.
    """
    color_of: dict[str, str] = {}
    for material in root.iter("material"):
        color = material.find("color")
        if color is None:
            continue
        words = color.get("rgba", "").split()
        color.set("rgba", " ".join(words if len(words) <= 4 else [*words[:3], words[-1]]))
        name = material.get("name", "")
        if color_of.setdefault(name, color.get("rgba", "")) != color.get("rgba"):
            material.set("name", f"{name}_{len(color_of)}")
            color_of[material.get("name", "")] = color.get("rgba", "")


def _readable(file: Path, mesh: Path, readable_suffixes: tuple[str, ...], folder: Path) -> Path:
    """Return the mesh if its suffix is readable, else its OBJ conversion, made at its first use."""
    suffix = mesh.suffix.lower()
    if suffix in readable_suffixes:
        return mesh
    if suffix not in _CONVERTED:
        supported = [*readable_suffixes, *_CONVERTED]
        message = f"{file.name}: mesh {mesh.name} has an unsupported format; supported: {supported}"
        raise ModelInvalid(message, {"file": str(file), "reason": message})
    content = mesh.read_bytes()
    file_name = f"{hashlib.sha256(content).hexdigest()}-{mesh.stem[:_MAX_NAME_LENGTH]}{suffix}.obj"
    target = folder / conversion_version() / file_name
    if target.is_file():
        target.touch()
    else:
        try:
            text = _as_obj(content, suffix)
        except Exception as fault:  # trimesh's readers raise errors of any class
            message = f"{file.name}: mesh {mesh.name} cannot be read: {fault}"
            raise ModelInvalid(message, {"file": str(file), "reason": str(fault)}) from fault
        write_atomically(target, text)
        evict_oldest(target.parent, _MAX_BYTES, "*.obj", _MIN_AGE)
    return target


def source_name(mesh: Path) -> str:
    """Return the name of a mesh's file; of a converted mesh, the name of its source."""
    converted = _CONVERTED_NAME.match(mesh.name)
    return converted[1] if converted else mesh.name


def conversion_version() -> str:
    """Return the name of the folder of meshes converted by this version of the code."""
    return f"{_VERSION}-{version('trimesh')}"


def _as_obj(content: bytes, suffix: str) -> str:
    # It imports half of scipy, which most processes never need.
    import trimesh  # noqa: PLC0415
    from trimesh.exchange.obj import export_obj  # noqa: PLC0415

    # First: trimesh's COLLADA reader would expand the entities of a document type.
    to_z_up_transform = to_z_up(content, suffix)
    loaded: Any = trimesh.load(BytesIO(content), file_type=suffix[1:], force="mesh")
    if not np.isfinite(loaded.vertices).all():
        message = "a vertex has coordinates that are not finite"
        raise ValueError(message)
    loaded.apply_transform(to_z_up_transform)
    text: str = export_obj(loaded, include_texture=False)
    return text


def cache_folder() -> Path:
    """Return the folder of reproducible files, created if needed."""
    home = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    folder = Path(home) / "wayproof"
    folder.mkdir(parents=True, exist_ok=True)
    return folder
