"""Scenes as resources."""

from datetime import datetime

from pydantic import ConfigDict, Field

from planning.world.documents.scene_document import SceneDocument
from service.api.models import ResponseModel
from service.queries.models.check import UncheckedPair
from service.scenes.summary_models import Group


class SceneBrief(ResponseModel):
    """A scene without its content."""

    id: str = Field(description="Of the scene")
    revision: int = Field(description="Of its content, from 1")
    digest: str = Field(description="sha256 of the content, the bytes of all files included")
    name: str = Field(description="For people")
    created_at: datetime = Field(description="When this revision was made (UTC)")


class Files(ResponseModel):
    """The files of a robot or a mesh, as they were when it entered the scene."""

    named: str = Field(description="What the document calls them: `model`, or the mesh's `uri`")
    main: str = Field(description="The robot's description, or the mesh; one of the paths")
    card: str = Field(description="The `robot.yaml` that goes with it; empty for none")
    sha256: dict[str, str] = Field(
        description="Of the bytes of every file, by path relative to the folder of all"
    )


class Scene(SceneBrief):
    """A scene: its document and what it holds once loaded."""

    model_config = ConfigDict(title="Scene")

    groups: list[Group] = Field(description="What can be planned for")
    frames: list[str] = Field(description="Frames that poses may be given in")
    bodies: list[str] = Field(description="Everything that can collide")
    num_pairs: int = Field(description="Pairs of bodies that are kept apart")
    assumed: list[str] = Field(
        description="Joints whose rate limits nobody states, so that ours are assumed"
    )
    unchecked: list[UncheckedPair] = Field(
        default=[], description="Pairs of bodies that no collision check looks at, and why"
    )
    warnings: list[str] = Field(description="What was found odd, for example concave meshes")
    document: SceneDocument = Field(description="As it was posted or edited, defaults filled in")
    files: dict[str, Files] = Field(
        default={},
        description="What its robots and meshes were made from, by name: they are kept, and no "
        "change of a file on the disk changes this scene",
    )


class ScenePage(ResponseModel):
    """Scenes, newest first."""

    items: list[SceneBrief] = Field(description="On this page")
    next: str | None = Field(description="Cursor of the next page; null on the last one")
