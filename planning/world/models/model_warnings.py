"""Warnings about a robot's description, for the scene's summary."""

import logging
import re
import threading
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from typing import Any, override

from pydrake.geometry import Role
from pydrake.multibody.tree import ModelInstanceIndex

_DRAKE = logging.getLogger("drake")
_LOCATION_PREFIX = re.compile(r"^.*?:(\d+): warning: ")
# Warnings about features that `planning` reads itself, or that affect neither motions nor
# collisions.
_IRRELEVANT = re.compile(
    r"mimic|floating|transmission|equality|texture|actuat|effort|material|friction|damping|sensor"
    r"|keyframe|gazebo|light|camera|site|plugin|statistic|visual",
    re.IGNORECASE,
)


class _Collector(logging.Filter):
    """Log handler that collects Drake's warnings by thread; only errors pass on.

    Drake's log level is that of errors while no thread collects: its own threads must not wait for
    Python's lock because of a warning.
    """

    def __init__(self) -> None:
        super().__init__()
        self.texts: dict[int, list[str]] = {}
        self._lock = threading.Lock()
        _DRAKE.setLevel(logging.ERROR)
        _DRAKE.addFilter(self)

    @override
    def filter(self, record: logging.LogRecord) -> bool:
        own = self.texts.get(threading.get_ident())
        if own is not None and record.levelno == logging.WARNING:
            own.append(record.getMessage())
        return record.levelno >= logging.ERROR

    @contextmanager
    def collected(self) -> Generator[list[str]]:
        """Yield the list to which this thread's warnings are added."""
        thread = threading.get_ident()
        with self._lock:
            own = self.texts[thread] = []
            _DRAKE.setLevel(logging.WARNING)
        try:
            yield own
        finally:
            with self._lock:
                del self.texts[thread]
                _DRAKE.setLevel(logging.WARNING if self.texts else logging.ERROR)


_COLLECTOR = _Collector()


@contextmanager
def parser_warnings(robot: str, warnings: list[str]) -> Generator[None]:
    """Add the warnings of Drake's parser inside the block to `warnings`, each once."""
    with _COLLECTOR.collected() as texts:
        yield
    warnings += [
        f"{robot}: {_LOCATION_PREFIX.sub(r'line \1: ', text)}"
        for text in dict.fromkeys(texts)
        if not _IRRELEVANT.search(_LOCATION_PREFIX.sub("", text))
    ]


def visual_only_warnings(
    scene_graph: Any, plant: Any, instances: Sequence[ModelInstanceIndex], robot: str
) -> list[str]:
    """Return a warning for every link with a visual and no collision shape."""
    inspector = scene_graph.model_inspector()
    found: list[str] = []
    for index in (i for instance in instances for i in plant.GetBodyIndices(instance)):
        frame = plant.GetBodyFrameIdIfExists(index)
        if frame is None or inspector.NumGeometriesForFrameWithRole(frame, Role.kProximity):
            continue
        if inspector.NumGeometriesForFrameWithRole(frame, Role.kIllustration):
            name = f"{robot}::{plant.get_body(index).name()}"
            found.append(f"{name} is visible but has no collision shape: it collides with nothing")
    return found
