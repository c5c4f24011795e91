"""keep_files(): a scene with the bytes of its files, so that it no longer depends on a disk."""

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
from planning.world.files.referenced_files import find_files
from planning.world.models.model_library import ModelLibrary, RobotSource
from planning.world.models.robot_card import read_robot_card


@dataclass(frozen=True)
class KeptScene:
    """A scene whose files are in a store.

    Attributes:
        scene: With `files` of all its robots and meshes, and of nothing else.
        store: Where they are.
    """

    scene: Scene
    store: FileStore

    def folder(self, robot: str) -> Path:
        """Return the folder that the copies of a robot's files are in."""
        return self.store.folder_of(self.scene.files[robot].sha256)

    def source(self, robot: str) -> RobotSource:
        """Return the copies of a robot's files.

        Raises:
            AssetNotFound: One is not there any more.
            ModelInvalid: Its card is none.
        """
        kept = self.scene.files[robot]
        folder = self.store.unfold(kept.sha256)
        card_file = folder / kept.card if kept.card else None
        card = read_robot_card(card_file) if card_file else None
        return RobotSource(kept.named, folder / kept.main, card, card_file)

    def thing(self, thing: SceneObject) -> SceneObject:
        """Return an object whose mesh is the copy of its file.

        Raises:
            AssetNotFound: It is not there any more.
        """
        if not isinstance(thing.shape, Mesh):
            return thing
        kept = self.scene.files[thing.name]
        copy = self.store.unfold(kept.sha256) / kept.main
        return replace(thing, shape=replace(thing.shape, uri=str(copy)))

    @contextmanager
    def faults_as_found(self) -> Generator[None]:
        """Have faults name the files that the scene names, and not their copies.

        Raises:
            ModelInvalid: As it was raised inside.
            AssetNotFound: As it was raised inside.
            SceneInvalid: As it was raised inside.
        """
        found = {
            str(self.store.folder_of(kept.sha256)): _origin(kept)
            for kept in self.scene.files.values()
        }
        with told_as({**found, str(self.store.meshes): "meshes"}):
            yield


@contextmanager
def told_as(names: Mapping[str, str]) -> Generator[None]:
    """Have faults name folders as the caller knows them.

    Args:
        names: What stands for each folder; faults of files that are not in any stay as they are.

    Raises:
        ModelInvalid: As it was raised inside.
        AssetNotFound: As it was raised inside.
        SceneInvalid: As it was raised inside.
    """
    try:
        yield
    except (ModelInvalid, AssetNotFound, SceneInvalid) as fault:
        raise type(fault)(_retold(fault.detail, names), _retold(fault.evidence, names)) from fault


def _retold(content: Any, names: Mapping[str, str]) -> Any:
    match content:
        case str():
            for folder, name in names.items():
                content = content.replace(folder, name)
            return content
        case Mapping():
            return {key: _retold(item, names) for key, item in content.items()}
        case list() | tuple():
            return [_retold(item, names) for item in content]
        case _:
            return content


def _origin(kept: KeptFiles) -> str:
    """Return what the folder of the files is called: a robot's name, or where its path says."""
    if "/" not in kept.named and kept.named != kept.main:
        return kept.named
    return kept.named.removesuffix(kept.main).rstrip("/") or "."


def keep_files(scene: Scene, library: ModelLibrary) -> KeptScene:
    """Return a scene with its files kept: those that it says, the others as they are now.

    Args:
        scene: Whose `files` may be there already, all or some; those that were read for a model
            or mesh of another name are read anew.
        library: Where robots are found and copies are kept.

    Raises:
        UnknownName: There is no such robot.
        AssetNotFound: A file is not there, or paths are not allowed.
        ModelInvalid: A robot's card is none, or its files are too large.
        SceneInvalid: An object's mesh is not there.
    """
    keeper = _Keeper(library, FileStore(library.copies or cache_folder() / "copies"))
    files: dict[str, KeptFiles] = {}
    for robot in scene.robots:
        known = _known(scene, robot.name, robot.model)
        files[robot.name] = known or keeper.robot(robot.model)
    for i, thing in enumerate(scene.objects):
        if isinstance(thing.shape, Mesh):
            known = _known(scene, thing.name, thing.shape.uri)
            files[thing.name] = known or keeper.mesh(thing, i)
    return KeptScene(replace(scene, files=files), keeper.store)


def _known(scene: Scene, name: str, named: str) -> KeptFiles | None:
    kept = scene.files.get(name)
    return kept if kept is not None and kept.named == named else None


@dataclass
class _Keeper:
    """Reads each file once, however often the scene names it."""

    library: ModelLibrary
    store: FileStore
    robots: dict[str, KeptFiles] = field(default_factory=dict)
    meshes: dict[str, KeptFiles] = field(default_factory=dict)

    def robot(self, model: str) -> KeptFiles:
        if model not in self.robots:
            with told_as(self._names(model)):
                source = self.library.find(model)
                cards = [source.card_file] if source.card_file else []
                self.robots[model] = self._kept(model, source.file, cards)
        return self.robots[model]

    def _names(self, model: str) -> dict[str, str]:
        """Return how robots that are asked for by name know the library's folders."""
        if model not in self.library.names:
            return {}
        roots = self.library.roots
        return {str(root / model): model for root in roots} | {str(root): "" for root in roots}

    def mesh(self, thing: SceneObject, index: int) -> KeptFiles:
        assert isinstance(thing.shape, Mesh)  # noqa: S101  (the caller's case)
        uri, path = thing.shape.uri, f"objects.{index}.shape"
        if not self.library.allow_paths:
            message = f"{path}: files cannot be named by path here, so there is no mesh {uri!r}"
            raise AssetNotFound(message, {"uri": uri, "path": path, "known": []})
        if not Path(uri).is_file():
            message = f"{path}: object {thing.name!r} does not load: there is no file {uri!r}"
            raise SceneInvalid(message, {"path": path, "uri": uri})
        if uri not in self.meshes:
            self.meshes[uri] = self._kept(uri, Path(uri), [])
        return self.meshes[uri]

    def _kept(self, named: str, main: Path, cards: Sequence[Path]) -> KeptFiles:
        found = find_files(main, cards)
        sha256 = {path: self.store.put(content) for path, content in found.content.items()}
        return KeptFiles(named, found.main, found.path(cards[0]) if cards else "", sha256)
