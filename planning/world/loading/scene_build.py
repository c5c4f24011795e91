"""Build: intermediate state of a scene being built in Drake."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydrake.geometry import GeometryId
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Frame, ModelInstanceIndex

from planning.domain.geometry.unchecked_pair import UncheckedReason
from planning.domain.scene.scene import SceneRobot
from planning.errors import SceneInvalid
from planning.world.models.model_file import ModelFile
from planning.world.models.model_library import RobotSource


@dataclass(frozen=True)
class LoadedRobot:
    """Robot of the scene with its files and Drake's model instance."""

    scene_robot: SceneRobot
    source: RobotSource
    file: ModelFile
    instance: ModelInstanceIndex


@dataclass
class Build:
    """Mutable state of the builder.

    `loose_names` has the objects that are not welded to the frame that they are attached to but
    float in it. `files` has the parsed description of each robot; `static_names` the names of
    objects outside of the plant, `static_names_added` those already processed; `unchecked` the
    reason and the evidence of every pair of bodies, by both full names, that collision checks leave
    out; `half_spaces` the body of each half space that is fixed to the world, and `is_simulated`
    whether something stands in for these that pushes back; `warnings` are those of the scene's
    summary.
    """

    builder: Any
    plant: MultibodyPlant
    static_names: frozenset[str] = frozenset()
    loose_names: frozenset[str] = frozenset()
    static_names_added: set[str] = field(default_factory=set)
    robots: list[LoadedRobot] = field(default_factory=list)
    files: dict[Path, ModelFile] = field(default_factory=dict)
    bodies: dict[str, BodyIndex] = field(default_factory=dict)
    frames: dict[str, Frame] = field(default_factory=dict)
    unchecked: dict[frozenset[str], tuple[UncheckedReason, str]] = field(default_factory=dict)
    half_spaces: dict[GeometryId, str] = field(default_factory=dict)
    is_simulated: bool = False
    warnings: list[str] = field(default_factory=list)

    @property
    def known_bodies(self) -> set[str]:
        """Names of all bodies, in the plant or not."""
        return {*self.bodies, *self.static_names}


def validate_unused_name(build: Build, name: str, path: str) -> None:
    """Raise if a name is already in use.

    Raises:
        SceneInvalid: The name is in use.
    """
    is_taken = name in build.bodies or name in build.frames or name in build.static_names_added
    if is_taken or any(robot.scene_robot.name == name for robot in build.robots):
        message = f"{path}: the name {name!r} is taken; robots, objects and frames share names"
        raise SceneInvalid(message, {"path": path, "name": name})
