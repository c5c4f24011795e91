"""Loaded worlds, kept warm in this process by scene digest, which covers the bytes of all files.

Where the live state has the robots elsewhere than the document, the world of one state is made
from that of another: nothing is loaded anew.
"""

import json
import threading
from collections import OrderedDict
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from weakref import WeakSet

from planning import ModelLibrary, Scene, World, load_world
from planning.domain.scene.kept_files import KeptFiles
from planning.domain.scene.scene import SceneRobot
from planning.errors import InputError
from planning.world.documents.scene_document import SceneDocument
from service.errors import SceneNotKept
from service.jobs.host_folder import artifact_path, files_folder, host_folder
from service.scenes.live import JointPositions
from service.scenes.tasks import Library, SceneWork, StoredScene

# A Drake world of an arm and some obstacles takes 5 to 40 MB.
MAX_WORLDS = 8

# Digest of the scene, positions that its live state has (JSON), library.
type Key = tuple[str, str, ModelLibrary]
_NOT_MOVED = "{}"


@dataclass(frozen=True)
class _Idle:
    """A world, and its robots as the document has them."""

    world: World
    described: tuple[SceneRobot, ...]


_idle: OrderedDict[tuple[Key, int], _Idle] = OrderedDict()
# What shares an engine must not be lent to two tasks at a time.
_lent: WeakSet[World] = WeakSet()
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
    key = _key(work)
    borrowed = _take(key)
    if borrowed is None:
        described = described_scene(work)
        world = load_like(posed(described, work.scene.positions), key[2])
        borrowed = _Idle(world, described.robots)
        if _described_digest(borrowed) != work.scene.digest:
            raise SceneNotKept.of(work.scene.digest)
    try:
        yield borrowed.world
    finally:
        _put_back(key, borrowed)


def described_scene(work: SceneWork) -> Scene:
    """Return the scene that a task is about as its document has it, from here or from its file.

    Raises:
        SceneNotKept: It was written before scenes kept their files, or is lost.
        SceneInvalid: Its files cannot be meant.
    """
    found = warm_scene(work)
    if found is None:
        posted, files = read_stored(work.scene)
        found = replace(posted.value(), files=files)
    return found


def warm_scene(work: SceneWork) -> Scene | None:
    """Return the scene of a task as its document has it, if a world of it is idle here."""
    digest, _, library = _key(work)
    with _lock:
        for stored in reversed(_idle):
            key, idle = stored[0], _idle[stored]
            if (key[0], key[2]) == (digest, library):
                return replace(idle.world.scene, robots=idle.described)
    return None


def posed(described: Scene, positions: Mapping[str, JointPositions]) -> Scene:
    """Return a scene with robots where its live state has them, by robot and joint."""
    if not positions:
        return described
    robots = [
        replace(robot, positions=_merged(robot, positions[robot.name]))
        if robot.name in positions
        else robot
        for robot in described.robots
    ]
    return replace(described, robots=tuple(robots))


def _merged(robot: SceneRobot, live: JointPositions) -> dict[str, float | tuple[float, ...]]:
    """Return positions by joint: joints of no group stay where the document has them."""
    given = robot.positions if isinstance(robot.positions, dict) else {}
    own = {name.removeprefix(f"{robot.name}::"): value for name, value in given.items()}
    placed = {k: tuple(v) if isinstance(v, list) else v for k, v in live.items()}
    return {**own, **placed}


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
    """Load a scene, with what it has in common with one that is idle here; `keep` it or drop it.

    Raises:
        InputError: The scene does not load.
    """
    found = _take_like(scene, library)
    if found is None:
        return load_world(scene, library)
    key, like = found
    try:
        world = load_world(scene, library, previous=like.world)
    except InputError:
        _put_back(key, like)
        raise
    with _lock:
        _lent.add(world)
        _lent.discard(like.world)
    if not world.has_objects_of(like.world):  # of one table of objects only the latest stays
        _put_back(key, like)
    return world


def keep(world: World, library: ModelLibrary) -> None:
    """Keep a world that was loaded as its document has it for the next task that needs it."""
    _put_back((world.digest, _NOT_MOVED, library), _Idle(world, world.scene.robots))


def _key(work: SceneWork) -> Key:
    moved = json.dumps(work.scene.positions, sort_keys=True)
    return work.scene.digest, moved, library_of(work.library)


def _described_digest(idle: _Idle) -> str:
    """Return the digest of the scene of a world as its document has it."""
    scene = idle.world.scene
    if scene.robots == idle.described:
        return idle.world.digest
    robots = tuple(
        replace(robot, positions=described.positions)
        for robot, described in zip(scene.robots, idle.described, strict=True)
    )
    return replace(scene, robots=robots).digest


def _take(key: Key) -> _Idle | None:
    with _lock:
        for stored in reversed(_idle):
            if stored[0] == key and not _is_engine_lent(_idle[stored].world):
                return _lend(stored)
    return None


def _lend(stored: tuple[Key, int]) -> _Idle:
    idle = _idle.pop(stored)
    _lent.add(idle.world)
    return idle


def _is_engine_lent(world: World) -> bool:
    return any(world.shares_engine_with(lent) for lent in _lent)


def _take_like(scene: Scene, library: ModelLibrary) -> tuple[Key, _Idle] | None:
    """Return an idle world that may have Drake's model in common.

    The last used one of those with the same objects, if there is one, for they may have moved; else
    the last used one with the same robots.
    """
    robots, names = _names(scene)
    with _lock:
        alike = [
            stored
            for stored, idle in reversed(_idle.items())
            if stored[0][2] == library
            and _names(idle.world.scene)[0] == robots
            and not _is_engine_lent(idle.world)
        ]
        moved = (stored for stored in alike if _names(_idle[stored].world.scene)[1] == names)
        found = next(moved, alike[0] if alike else None)
        return None if found is None else (found[0], _lend(found))


def _names(scene: Scene) -> tuple[list[tuple[str, str]], list[str]]:
    """Return the names and models of the robots of a scene, and the names of its objects."""
    robots = [(robot.name, robot.model) for robot in scene.robots]
    return robots, [thing.name for thing in scene.objects]


def _put_back(key: Key, idle: _Idle) -> None:
    with _lock:
        _lent.discard(idle.world)
        _idle[key, id(idle.world)] = idle
        while len(_idle) > MAX_WORLDS:
            _idle.popitem(last=False)
