"""What tasks about a scene are given."""

from service.jobs.tasks import TaskModel


class Library(TaskModel):
    """Robots that may be loaded, by the server's settings.

    Attributes:
        model_roots: Folders of robots besides the bundled ones.
        allow_paths: Whether scenes may name files by path.
        copies: The folder of the copies of files that scenes were made from.
    """

    model_roots: list[str]
    allow_paths: bool
    copies: str


class LibraryWork(TaskModel):
    """What a task that loads robots is given."""

    library: Library


class StoredScene(TaskModel):
    """A scene as workers load it.

    Attributes:
        digest: Of its content, the bytes of all files included.
        document: The path of its JSON.
    """

    digest: str
    document: str


class SceneWork(LibraryWork):
    """What a task about a scene is given."""

    scene: StoredScene
