"""Tasks that load scenes, and what every task about a scene is given."""

from typing import Literal, Self

from pydantic import BaseModel, Field

from service.jobs.json_text import Encoded
from service.jobs.outline import Outline
from service.jobs.task import Task, TaskModel
from service.scenes.models.edits import SceneEdit
from service.scenes.models.scene import SceneSummary

type Media = Literal["json", "yaml"]


class Library(TaskModel):
    """Robots that may be loaded, by the server's settings.

    Attributes:
        model_roots: Folders of robots besides the bundled ones.
        allow_paths: Whether scenes may name files by path.
    """

    model_roots: list[str]
    allow_paths: bool


class LibraryWork(TaskModel):
    """What a task that loads robots is given."""

    library: Library


class StoredScene(TaskModel):
    """A scene as workers load it.

    Attributes:
        digest: Of its content, the bytes of all files included.
        document: sha256 of the artifact that has its document, and says what its files are.
        positions: Where its live state has robots that are not where the document has them, by
            robot and joint: all joints of their groups [rad or m].
    """

    digest: str
    document: str
    positions: dict[str, dict[str, float | list[float]]] = Field(default_factory=dict)

    def is_same(self, other: "StoredScene") -> bool:
        """Return whether another one has the same content, and its robots in the same places."""
        return (self.digest, self.positions) == (other.digest, other.positions)


class SceneWork(LibraryWork):
    """What a task about a scene is given."""

    artifact_members = ("scene.document",)

    scene: StoredScene


class RequestWork[Request: BaseModel](SceneWork):
    """A request to a scene."""

    request: Request

    @classmethod
    def about(cls, scene: SceneWork, request: Request) -> Self:
        """Return a request with what every task about a scene is given."""
        return cls(library=scene.library, scene=scene.scene, request=request)


class LoadWork(LibraryWork):
    """A scene as it was posted."""

    text: str
    media: Media


class LoadedScene(TaskModel):
    """A scene that a worker has loaded; what is large and goes out as it is stays text.

    Attributes:
        name: For people.
        digest: sha256 of the content, the bytes of all files included.
        summary: What it holds, but for:
        unchecked: Pairs of bodies that no collision check looks at, a list.
        document: What was posted, or what came of editing it, defaults filled in.
    """

    name: str
    digest: str
    summary: SceneSummary
    unchecked: Encoded
    document: Encoded


_TEXTS = Outline(result=("unchecked", "document"))
LOAD_SCENE = Task("load_scene", LoadWork, LoadedScene, outline=_TEXTS)
EDIT_SCENE = Task("edit_scene", RequestWork[SceneEdit], LoadedScene, outline=_TEXTS)
