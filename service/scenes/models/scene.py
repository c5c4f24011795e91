"""Scenes as resources."""

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Self

from pydantic import ConfigDict, Field

from planning.domain.scene import summary as domain
from planning.domain.scene.kept_files import KeptFiles
from planning.world.documents.scene_document import SceneDocument
from service.api.models import ResponseModel
from service.scenes.models.pairs import UncheckedPair
from service.scenes.models.summary import Group
from service.scenes.models.verdicts import ExecutionVerdict


class SceneBrief(ResponseModel):
    """A scene without its content."""

    model_config = ConfigDict(from_attributes=True)

    id: str = Field(description="Id of the scene")
    revision: int = Field(description="Revision of its content, from 1")
    digest: str = Field(description="sha256 of the content, the bytes of all files included")
    name: str = Field(description="Name for people")
    created_at: datetime = Field(description="Time at which this revision was made (UTC)")


class Files(ResponseModel):
    """The files of a robot or a mesh, as they were when it entered the scene."""

    model_config = ConfigDict(from_attributes=True)

    named: str = Field(description="Name in the document: `model`, or the mesh's `uri`")
    main: str = Field(description="The robot's description, or the mesh; one of the paths")
    card: str = Field(description="The `robot.yaml` that goes with it; empty for none")
    sha256: dict[str, str] = Field(
        description="sha256 of the bytes of every file, by path relative to the folder of all"
    )


class SceneSummary(ResponseModel):
    """What a scene holds once loaded, as it is stored; older servers stored less.

    Attributes:
        files: None where a server kept no files.
    """

    groups: list[Group] = []
    frames: list[str] = []
    bodies: list[str] = []
    num_pairs: int = 0
    assumed: list[str] = []
    warnings: list[str] = []
    files: dict[str, Files] | None = None

    @classmethod
    def from_domain(
        cls,
        summary: domain.SceneSummary,
        aliases: Mapping[str, Sequence[str]],
        files: Mapping[str, KeptFiles],
    ) -> Self:
        """Return the summary of a loaded scene.

        Args:
            summary: Of the world.
            aliases: Other names of each group.
            files: By the name of the robot or object that was made from them.
        """
        return cls(
            groups=[
                Group.from_summary(group, aliases.get(name, ()))
                for name, group in summary.groups.items()
            ],
            frames=list(summary.frames),
            bodies=list(summary.bodies),
            num_pairs=summary.num_pairs,
            assumed=list(summary.assumed),
            warnings=list(summary.warnings),
            files={name: Files.model_validate(kept) for name, kept in files.items()},
        )


class Scene(SceneBrief):
    """A scene: its document and what it holds once loaded."""

    model_config = ConfigDict(title="Scene")

    groups: list[Group] = Field(description="Groups that can be planned for")
    frames: list[str] = Field(description="Frames that poses may be given in")
    bodies: list[str] = Field(description="Everything that can collide")
    num_pairs: int = Field(description="Pairs of bodies that are kept apart")
    assumed: list[str] = Field(
        description="Joints whose rate limits are assumed, because no source states them"
    )
    unchecked: list[UncheckedPair] = Field(
        default=[], description="Pairs of bodies that no collision check looks at, and why"
    )
    warnings: list[str] = Field(description="Oddities of the scene, for example concave meshes")
    document: SceneDocument = Field(
        description="Document as it was posted or edited, defaults filled in"
    )
    files: dict[str, Files] = Field(
        default={},
        description="Files that its robots and meshes were made from, by name. They are "
        "kept: no change of a file on the disk changes this scene",
    )


class EditedScene(Scene):
    """A scene after an edit, and what that means for the motions that are carried out in it."""

    model_config = ConfigDict(title="EditedScene")

    executions: list[ExecutionVerdict] = Field(
        description="Each execution that waits or moves in the scene, and whether what is left of "
        "its motion is proven in this revision"
    )


class ScenePage(ResponseModel):
    """Scenes, newest first."""

    items: list[SceneBrief] = Field(description="Scenes on this page")
    next: str | None = Field(description="Cursor of the next page; null on the last one")
