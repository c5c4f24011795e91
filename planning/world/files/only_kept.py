"""require_kept(): whether a robot is made of its kept files and of nothing else on the disk."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydrake.geometry import Convex, Mesh, Role
from pydrake.multibody.tree import ModelInstanceIndex

from planning.errors import ModelInvalid
from planning.world.loading.scene_build import Build


def require_kept(
    build: Build,
    instances: Sequence[ModelInstanceIndex],
    description: Path,
    folders: Sequence[Path],
) -> None:
    """Go on only if every mesh of a robot is a kept file, or was made from one.

    Args:
        build: With the robot.
        instances: The robot's.
        description: Of the robot, among its kept files.
        folders: That its kept files are in, and what was made from them.

    Raises:
        ModelInvalid: Drake has read another one, which may change without notice.
    """
    for file in _mesh_files(build, instances):
        if not any(file.is_relative_to(kept) for kept in folders):
            message = f"{description.name} names {str(file)!r} in a way that cannot be kept: name "
            message += "it relative to the description, or by package://"
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
