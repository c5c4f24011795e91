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
from planning.world.files.keep_files import KeptScene, keep_files
from planning.world.loading.builder import build_alone
from planning.world.models.model_library import ModelLibrary

# Time limit for one file [s]; a robot of a hundred meshes takes some seconds.
_LONGEST = 30.0
# Memory that a file may use in addition to the process's own.
_MOST_MEMORY = 8 * 2**30
_NEXT, _DONE, _NO_MEMORY = b"n", b"d", b"m"
_ENDED = "the process that loads it ends"
# Tried files by content, in this process; another one tries again.
_harmless: set[str] = set()

type Thing = SceneRobot | SceneObject


def tried(scene: Scene, library: ModelLibrary, longest: float = _LONGEST) -> Scene:
    """Return a scene with its files, after a trial load of each file in a fork.

    Robots of the library are trusted, and are not tried. Nothing is tried in a process with
    several threads, which cannot be forked.

    Args:
        scene: To load next.
        library: Library of robots, with the folder of copies.
        longest: Time limit for one file [s].

    Raises:
        ModelInvalid: A file ends the process; the evidence names it.
        WayproofError: As of `load_world`, where the files cannot be stored.
    """
    kept = keep_files(scene, library)
    trusted = set(library.names)
    things: list[Thing] = [r for r in kept.scene.robots if r.model not in trusted]
    things += kept.meshes
    by_content = {kept.scene.files[thing.name].content: thing for thing in things}
    new = {content: thing for content, thing in by_content.items() if content not in _harmless}
    if new and threading.active_count() == 1:
        with kept.faults_as_found():
            _try(kept, list(new.values()), longest)
        _harmless.update(new)
    return kept.scene


def _try(kept: KeptScene, things: Sequence[Thing], longest: float) -> None:
    """Load things in a fork, and raise for the one at which the fork ended."""
    near, far = os.pipe()
    parent = os.getpid()
    try:
        child = fork()
    except OSError:  # no more processes
        os.close(near)
        os.close(far)
        return
    if not child:
        _load(kept, things, far, parent)
    os.close(far)
    number, why = 0, _ENDED
    try:
        number, why = _watch(near, longest)
    finally:
        os.close(near)
        status = end_fork(child)
    if why == _ENDED and os.WIFSIGNALED(status):
        why = f"the process that loads it ends by {signal.Signals(os.WTERMSIG(status)).name}"
    if why:
        raise _fault(kept, things[number], why)


def _load(kept: KeptScene, things: Sequence[Thing], far: int, parent: int) -> None:
    """In the child: load one thing after the other, and report each index; never return."""
    try:
        die_with_parent()
        if os.getppid() == parent:
            faulthandler.disable()  # the parent reports the crash
            _bound_memory()
            for _ in map(partial(_load_one, kept, far), things):
                pass
            os.write(far, _DONE)
    except MemoryError:
        os.write(far, _NO_MEMORY)
    finally:
        os._exit(0)


def _load_one(kept: KeptScene, far: int, thing: Thing) -> None:
    os.write(far, _NEXT)
    try:
        build_alone(thing, kept)
    except MemoryError:
        raise
    except (Exception, SystemExit):  # noqa: BLE001, S110  (who loads it next says what is wrong)
        pass


def _bound_memory() -> None:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    most = pages * resource.getpagesize() + _MOST_MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _watch(near: int, longest: float) -> tuple[int, str]:
    """Return the thing that was loaded last, and why the fork ended; "" if all were loaded."""
    number = -1
    with selectors.DefaultSelector() as selector:
        selector.register(near, selectors.EVENT_READ)
        while selector.select(longest):
            match os.read(near, 1):
                case b"n":
                    number += 1
                case b"d":
                    return max(number, 0), ""
                case b"m":
                    return max(number, 0), f"it needs more than {_MOST_MEMORY >> 30} GiB of memory"
                case _:
                    return max(number, 0), _ENDED
    return max(number, 0), f"it takes more than {longest:g} s"


def _fault(kept: KeptScene, thing: Thing, why: str) -> ModelInvalid:
    files = kept.scene.files[thing.name]
    file = str(kept.store.folder_of(files.sha256) / files.main)
    kind = "robot" if isinstance(thing, SceneRobot) else "object"
    message = f"{kind} {thing.name!r}: {files.main} cannot be loaded: {why}"
    return ModelInvalid(message, {"file": file, "reason": why})
