"""Trial load of a scene's files in a forked process, where a crash does no harm.

The parsers of meshes and descriptions are C++ that trusts its input: some files end the process,
or fill its memory. So a file of unknown origin is first loaded in a fork of this process.
"""

import faulthandler
import os
import resource
import selectors
import signal
import threading
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from planning.domain.scene.scene import Scene, SceneObject, SceneRobot
from planning.errors import ModelInvalid
from planning.parallel.fork_pool import die_with_parent, end_fork, fork
from planning.world.files.stored_scene import StoredScene, store_files
from planning.world.loading.builder import build_single
from planning.world.models.model_library import ModelLibrary

# Time limit for one file [s]; a robot of a hundred meshes takes some seconds.
_TIME_LIMIT = 30.0
# Memory that a file may use in addition to the process's own.
_MAX_MEMORY = 8 * 2**30
_NEXT, _DONE, _NO_MEMORY = b"n", b"d", b"m"
_PROCESS_ENDED = "the process that loads it ends"
# Tried files by content, in this process; another one tries again.
_loadable: set[str] = set()

type RobotOrObject = SceneRobot | SceneObject


def trial_load(scene: Scene, library: ModelLibrary, time_limit: float = _TIME_LIMIT) -> Scene:
    """Return a scene with its files, after a trial load of each file in a fork.

    Robots of the library are trusted, and are not tried. Nothing is tried in a process with
    several threads, which cannot be forked.

    Args:
        scene: To load next.
        library: Library of robots, with the folder of copies.
        time_limit: Time limit for one file [s].

    Raises:
        ModelInvalid: A file ends the process; the evidence names it.
        WayproofError: As of `load_world`, where the files cannot be stored.
    """
    stored = store_files(scene, library)
    trusted = set(library.names)
    things: list[RobotOrObject] = [r for r in stored.scene.robots if r.model not in trusted]
    things += stored.meshes
    by_content = {stored.scene.files[thing.name].content: thing for thing in things}
    new = {content: thing for content, thing in by_content.items() if content not in _loadable}
    if new and threading.active_count() == 1:
        with stored.original_names_in_errors():
            _load_in_fork(stored, list(new.values()), time_limit)
        _loadable.update(new)
    return stored.scene


def _load_in_fork(stored: StoredScene, things: Sequence[RobotOrObject], time_limit: float) -> None:
    """Load robots and objects in a fork, and raise for the one at which the fork ended."""
    read_end, write_end = os.pipe()
    parent = os.getpid()
    try:
        child = fork()
    except OSError:  # no more processes
        os.close(read_end)
        os.close(write_end)
        return
    if not child:
        _load(stored, things, write_end, parent)
    os.close(write_end)
    number, reason = 0, _PROCESS_ENDED
    try:
        number, reason = _wait_for_fork(read_end, time_limit)
    finally:
        os.close(read_end)
        status = end_fork(child)
    if reason == _PROCESS_ENDED and os.WIFSIGNALED(status):
        reason = f"the process that loads it ends by {signal.Signals(os.WTERMSIG(status)).name}"
    if reason:
        raise _fault(stored, things[number], reason)


def _load(
    stored: StoredScene, things: Sequence[RobotOrObject], write_end: int, parent: int
) -> None:
    """In the child: load one after the other, and report each; never return."""
    try:
        die_with_parent()
        if os.getppid() == parent:
            faulthandler.disable()  # the parent reports the crash
            _limit_memory()
            for _ in map(partial(_load_one, stored, write_end), things):
                pass
            os.write(write_end, _DONE)
    except MemoryError:
        os.write(write_end, _NO_MEMORY)
    finally:
        os._exit(0)


def _load_one(stored: StoredScene, write_end: int, thing: RobotOrObject) -> None:
    os.write(write_end, _NEXT)
    try:
        build_single(thing, stored)
    except MemoryError:
        raise
    except (Exception, SystemExit):  # noqa: BLE001, S110  (the next load reports it)
        pass


def _limit_memory() -> None:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    max_bytes = pages * resource.getpagesize() + _MAX_MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (max_bytes, max_bytes))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _wait_for_fork(read_end: int, time_limit: float) -> tuple[int, str]:
    """Return the index loaded last, and why the fork ended; "" if all were loaded."""
    number = -1
    with selectors.DefaultSelector() as selector:
        selector.register(read_end, selectors.EVENT_READ)
        while selector.select(time_limit):
            match os.read(read_end, 1):
                case b"n":
                    number += 1
                case b"d":
                    return max(number, 0), ""
                case b"m":
                    return max(number, 0), f"it needs more than {_MAX_MEMORY >> 30} GiB of memory"
                case _:
                    return max(number, 0), _PROCESS_ENDED
    return max(number, 0), f"it takes more than {time_limit:g} s"


def _fault(stored: StoredScene, thing: RobotOrObject, reason: str) -> ModelInvalid:
    files = stored.scene.files[thing.name]
    file = str(stored.store.folder_of(files.sha256) / files.main)
    kind = "robot" if isinstance(thing, SceneRobot) else "object"
    message = f"{kind} {thing.name!r}: {files.main} cannot be loaded: {reason}"
    return ModelInvalid(message, {"file": file, "reason": reason})
