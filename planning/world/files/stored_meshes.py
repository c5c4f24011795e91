"""validate_stored_meshes(): check that a robot was loaded from its stored files only."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydrake.geometry import Convex, Mesh, Role
from pydrake.multibody.tree import ModelInstanceIndex

from planning.errors import ModelInvalid
from planning.world.loading.scene_build import Build


def validate_stored_meshes(
    build: Build,
    instances: Sequence[ModelInstanceIndex],
    description: Path,
    folders: Sequence[Path],
) -> None:
    """Raise unless every mesh of a robot is a stored file, or was converted from one.

    Args:
        build: With the robot.
        instances: The robot's.
        description: Of the robot, among its stored files.
        folders: Folders of its stored files, and of meshes converted from them.

    Raises:
        ModelInvalid: Drake has read another file, which may change without notice.
    """
    for file in _mesh_files(build, instances):
        if not any(file.is_relative_to(kept) for kept in folders):
            message = f"{description.name} refers to {str(file)!r} by a path that cannot be copied "
            message += "with the scene: use a path relative to the description, or package://"
            raise ModelInvalid(message, {"file": str(description), "reason": message})


def _mesh_files(build: Build, instances: Sequence[ModelInstanceIndex]) -> set[Path]:
    inspector: Any = build.builder.scene_graph().model_inspector()
    found: set[Path] = set()
    for instance in instances:
        for body in build.plant.GetBodyIndices(instance):
            frame = build.plant.GetBodyFrameIdIfExists(body)
            for role in (Role.kProximity, Role.kIllustration, Role.kPerception):
                for geometry in inspector.GetGeometries(frame, role) if frame else ():
                    shape = inspector.GetShape(geometry)
                    if isinstance(shape, Mesh | Convex) and shape.source().is_path():
                        found.add(Path(shape.source().path()))
    return found
