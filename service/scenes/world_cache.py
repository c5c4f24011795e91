"""Loaded worlds, kept warm in this process by scene digest, which covers the bytes of all files."""

import json
import threading
from collections import OrderedDict
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from planning import ModelLibrary, Scene, World, load_world
from planning.domain.scene.kept_files import KeptFiles
from planning.errors import InputError
from planning.world.documents.scene_document import SceneDocument
from service.errors import SceneNotKept
from service.jobs.host_folder import artifact_path, files_folder, host_folder
from service.scenes.tasks import Library, SceneWork, StoredScene

# A Drake world of an arm and some obstacles takes 5 to 40 MB.
MAX_WORLDS = 8

type Key = tuple[str, ModelLibrary]

_idle: OrderedDict[tuple[Key, int], World] = OrderedDict()
_lock = threading.Lock()


def library_of(library: Library) -> ModelLibrary:
    """Return the robots that the server's settings allow."""
    return _bundled(tuple(library.model_roots), library.allow_paths, host_folder())


@lru_cache(maxsize=8)  # every task asks, and a process has one answer
def _bundled(roots: tuple[str, ...], allow_paths: bool, folder: Path) -> ModelLibrary:  # noqa: FBT001
    copies = files_folder(folder)
    return ModelLibrary.bundled(*map(Path, roots), allow_paths=allow_paths, copies=copies)


@contextmanager
def borrow_world(work: SceneWork) -> Generator[World]:
    """Lend the world of a scene to one task at a time; load it if none is idle.

    Args:
        work: With the scene.

    Raises:
        InputError: The scene does not load.
        SceneNotKept: It is not what it was when it was accepted.
    """
    key = (work.scene.digest, library_of(work.library))
    world = _take(key)
    if world is None:
        posted, files = read_stored(work.scene)
        world = load_like(replace(posted.value(), files=files), key[1])
        if world.digest != work.scene.digest:
            raise SceneNotKept.of(work.scene.digest)
    try:
        yield world
    finally:
        _put_back(key, world)


def read_stored(scene: StoredScene) -> tuple[SceneDocument, Mapping[str, KeptFiles]]:
    """Return the document of the scene that a task is about, and the files that it was made from.

    Raises:
        SceneNotKept: It was written before scenes kept their files, or is lost.
        SceneInvalid: Its files cannot be meant.
    """
    try:
        text = artifact_path(host_folder(), scene.document).read_text(encoding="utf-8")
    except FileNotFoundError:
        raise SceneNotKept.of(scene.digest) from None
    written = json.loads(text)
    if written.get("files") is None:
        raise SceneNotKept.of(scene.digest)
    files = {name: KeptFiles.from_json(plain) for name, plain in written["files"].items()}
    return SceneDocument.model_validate(written["document"]), files


def load_like(scene: Scene, library: ModelLibrary) -> World:
    """Load a scene, with what it has in common with one that is idle here.

    Raises:
        InputError: The scene does not load.
    """
    like = _take_like(scene, library)
    if like is None:
        return load_world(scene, library)
    try:
        world = load_world(scene, library, previous=like)
    except InputError:
        keep(like, library)
        raise
    # What shares an engine must not be lent to two tasks: of revisions only the latest stays.
    if not world.shares_engine_with(like):
        keep(like, library)
    return world


def take_world(work: SceneWork) -> World | None:
    """Return the world of a scene if it is idle here; it is the caller's until it is kept."""
    return _take((work.scene.digest, library_of(work.library)))


def keep(world: World, library: ModelLibrary) -> None:
    """Keep a world that was loaded elsewhere for the next task that needs it."""
    _put_back((world.digest, library), world)


def _take(key: Key) -> World | None:
    with _lock:
        for stored in reversed(_idle):
            if stored[0] == key:
                return _idle.pop(stored)
    return None


def _take_like(scene: Scene, library: ModelLibrary) -> World | None:
    """Return the idle world, last used first, that may have Drake's model in common."""
    robots = [(robot.name, robot.model) for robot in scene.robots]
    with _lock:
        for stored in reversed(_idle):
            other = _idle[stored].scene
            if (
                stored[0][1] == library
                and len(other.objects) == len(scene.objects)
                and [(robot.name, robot.model) for robot in other.robots] == robots
            ):
                return _idle.pop(stored)
    return None


def _put_back(key: Key, world: World) -> None:
    with _lock:
        _idle[key, id(world)] = world
        while len(_idle) > MAX_WORLDS:
            _idle.popitem(last=False)
