"""store_files(): copy a scene's files into the store, so that it no longer depends on the disk."""

from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from planning.domain.geometry.shapes import Mesh
from planning.domain.scene.kept_files import KeptFiles
from planning.domain.scene.scene import Scene, SceneObject
from planning.errors import AssetNotFound, ModelInvalid, SceneInvalid
from planning.world.files.file_store import FileStore
from planning.world.files.mesh_files import cache_folder
from planning.world.files.referenced_files import find_referenced_files
from planning.world.models.model_library import ModelLibrary, RobotSource
from planning.world.models.robot_card import read_robot_card


@dataclass(frozen=True)
class StoredScene:
    """Scene whose files are in a store.

    Attributes:
        scene: With `files` of all its robots and meshes, and of nothing else.
        store: The store.
        meshes: The objects whose shapes are files, in order.
    """

    scene: Scene
    store: FileStore
    meshes: tuple[SceneObject, ...]

    def folder(self, robot: str) -> Path:
        """Return the folder of the copies of a robot's files."""
        return self.store.folder_of(self.scene.files[robot].sha256)

    def source(self, robot: str) -> RobotSource:
        """Return the copies of a robot's files.

        Raises:
            AssetNotFound: One does not exist any more.
            ModelInvalid: Its card is invalid.
        """
        stored = self.scene.files[robot]
        folder = self.store.materialize(stored.sha256)
        card_file = folder / stored.card if stored.card else None
        card = read_robot_card(card_file) if card_file else None
        return RobotSource(stored.named, folder / stored.main, card, card_file)

    def stored_object(self, thing: SceneObject) -> SceneObject:
        """Return an object whose mesh is the copy of its file.

        Raises:
            AssetNotFound: It does not exist any more.
        """
        if not isinstance(thing.shape, Mesh):
            return thing
        stored = self.scene.files[thing.name]
        copy = self.store.materialize(stored.sha256) / stored.main
        return replace(thing, shape=replace(thing.shape, uri=str(copy)))

    @contextmanager
    def original_names_in_errors(self) -> Generator[None]:
        """Rewrite errors raised inside to name the scene's own files, not their copies.

        Raises:
            ModelInvalid: As it was raised inside.
            AssetNotFound: As it was raised inside.
            SceneInvalid: As it was raised inside.
        """
        names = {
            str(self.store.folder_of(stored.sha256)): _origin(stored)
            for stored in self.scene.files.values()
        }
        with rename_folders_in_errors({**names, str(self.store.meshes): "meshes"}):
            yield


@contextmanager
def rename_folders_in_errors(names: Mapping[str, str]) -> Generator[None]:
    """Rewrite errors raised inside to name folders as the caller does.

    Args:
        names: Replacement of each folder; errors about files outside of them stay as they are.

    Raises:
        ModelInvalid: As it was raised inside.
        AssetNotFound: As it was raised inside.
        SceneInvalid: As it was raised inside.
    """
    try:
        yield
    except (ModelInvalid, AssetNotFound, SceneInvalid) as fault:
        raise type(fault)(
            _with_renamed_folders(fault.detail, names), _with_renamed_folders(fault.evidence, names)
        ) from fault


def _with_renamed_folders(content: Any, names: Mapping[str, str]) -> Any:
    match content:
        case str():
            for folder, name in names.items():
                content = content.replace(folder, name)
            return content
        case Mapping():
            return {key: _with_renamed_folders(item, names) for key, item in content.items()}
        case list() | tuple():
            return [_with_renamed_folders(item, names) for item in content]
        case _:
            return content


def _origin(stored: KeptFiles) -> str:
    """Return the name of the files' folder: a robot's name, or the folder of its path."""
    if "/" not in stored.named and stored.named != stored.main:
        return stored.named
    return stored.named.removesuffix(stored.main).rstrip("/") or "."


def store_files(scene: Scene, library: ModelLibrary) -> StoredScene:
    """Return a scene with its files stored: those in its `files`, the others as they are now.

    Args:
        scene: Its `files` may have all or some already; those that were read for a model or mesh of
            another name are read anew.
        library: Library of robots, with the folder of copies.

    Raises:
        UnknownName: There is no such robot.
        AssetNotFound: A file does not exist, or paths are not allowed.
        ModelInvalid: A robot's card is invalid, or its files are too large.
        SceneInvalid: An object's mesh does not exist.
    """
    copier = _FileCopier(library, FileStore(library.copies or cache_folder() / "copies"))
    files: dict[str, KeptFiles] = {}
    for robot in scene.robots:
        stored = _stored_files(scene, robot.name, robot.model)
        files[robot.name] = stored or copier.robot(robot.model)
    meshes = [
        (i, thing, thing.shape.uri)
        for i, thing in enumerate(scene.objects)
        if isinstance(thing.shape, Mesh)
    ]
    for i, thing, uri in meshes:
        files[thing.name] = _stored_files(scene, thing.name, uri) or copier.mesh(thing, i)
    objects = tuple(thing for _, thing, _ in meshes)
    return StoredScene(replace(scene, files=files), copier.store, objects)


def _stored_files(scene: Scene, name: str, named: str) -> KeptFiles | None:
    stored = scene.files.get(name)
    return stored if stored is not None and stored.named == named else None


@dataclass
class _FileCopier:
    """Copier that reads each file once, even if the scene names it several times."""

    library: ModelLibrary
    store: FileStore
    robots: dict[str, KeptFiles] = field(default_factory=dict)
    meshes: dict[str, KeptFiles] = field(default_factory=dict)

    def robot(self, model: str) -> KeptFiles:
        if model not in self.robots:
            with rename_folders_in_errors(self._names(model)):
                source = self.library.find(model)
                cards = [source.card_file] if source.card_file else []
                self.robots[model] = self._store(model, source.file, cards)
        return self.robots[model]

    def _names(self, model: str) -> dict[str, str]:
        """Return the library's folders by the names of its robots, for messages."""
        if model not in self.library.names:
            return {}
        roots = self.library.roots
        return {str(root / model): model for root in roots} | {str(root): "" for root in roots}

    def mesh(self, thing: SceneObject, index: int) -> KeptFiles:
        assert isinstance(thing.shape, Mesh)  # noqa: S101  (the caller's case)
        uri, path = thing.shape.uri, f"objects.{index}.shape"
        if not self.library.allow_paths:
            message = f"{path}: this library loads no files by path, so there is no mesh {uri!r}"
            raise AssetNotFound(message, {"uri": uri, "path": path, "known": []})
        if not Path(uri).is_file():
            message = f"{path}: object {thing.name!r} does not load: there is no file {uri!r}"
            raise SceneInvalid(message, {"path": path, "uri": uri})
        if uri not in self.meshes:
            self.meshes[uri] = self._store(uri, Path(uri), [])
        return self.meshes[uri]

    def _store(self, named: str, main: Path, cards: Sequence[Path]) -> KeptFiles:
        files = find_referenced_files(main, cards)
        sha256 = {path: self.store.put(content) for path, content in files.content.items()}
        return KeptFiles(named, files.main, files.path(cards[0]) if cards else "", sha256)
