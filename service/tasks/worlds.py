"""Loaded worlds, kept warm in this process by scene digest."""

import json
import threading
from collections import OrderedDict
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from planning import ModelLibrary, World, load_world, parse_scene

# A Drake world of an arm and some obstacles takes 5 to 40 MB.
MAX_WORLDS = 8

type Key = tuple[str, ModelLibrary]

_idle: OrderedDict[tuple[Key, int], World] = OrderedDict()
_lock = threading.Lock()


def library_of(payload: Mapping[str, Any]) -> ModelLibrary:
    """Return the robots that the server's settings allow."""
    roots = tuple(Path(root) for root in payload["model_roots"])
    return ModelLibrary.bundled(*roots, allow_paths=payload["allow_paths"])


@contextmanager
def borrow_world(payload: Mapping[str, Any]) -> Generator[World]:
    """Lend the world of a scene to one task at a time; load it if none is idle.

    Args:
        payload: With `scene` (`digest`, and `document`: the path of its JSON) and `library`.

    Raises:
        InputError: The scene does not load.
    """
    key = (payload["scene"]["digest"], library_of(payload["library"]))
    world = _take(key)
    if world is None:
        text = Path(payload["scene"]["document"]).read_text(encoding="utf-8")
        world = load_world(parse_scene(json.loads(text)), key[1])
    try:
        yield world
    finally:
        _put_back(key, world)


def keep(world: World, library: ModelLibrary) -> None:
    """Keep a world that was loaded elsewhere for the next task that needs it."""
    _put_back((world.digest, library), world)


def _take(key: Key) -> World | None:
    with _lock:
        for stored in reversed(_idle):
            if stored[0] == key:
                return _idle.pop(stored)
    return None


def _put_back(key: Key, world: World) -> None:
    with _lock:
        _idle[key, id(world)] = world
        while len(_idle) > MAX_WORLDS:
            _idle.popitem(last=False)
