"""What is odd about a robot's description, for the scene's summary."""

import logging
import re
import threading
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from typing import Any, override

from pydrake.geometry import Role
from pydrake.multibody.tree import ModelInstanceIndex

_DRAKE = logging.getLogger("drake")
_LOCK = threading.RLock()
_PLACE = re.compile(r"^.*?:(\d+): warning: ")
# What is read by `planning` itself, or matters to neither motions nor collisions.
_OURS = re.compile(
    r"mimic|floating|transmission|equality|texture|actuat|effort|material|friction|damping|sensor"
    r"|keyframe|gazebo|light|camera|site|plugin|statistic|visual",
    re.IGNORECASE,
)


class _Collector(logging.Handler):
    """Keeps what Drake warns of in this thread."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.texts: list[str] = []
        self._thread = threading.get_ident()

    @override
    def emit(self, record: logging.LogRecord) -> None:
        if record.thread == self._thread:
            self.texts.append(record.getMessage())


@contextmanager
def parser_warnings(robot: str, warnings: list[str]) -> Generator[None]:
    """Add what Drake's parser warns of inside to `warnings`, each once."""
    collector = _Collector()
    with _LOCK:
        level, propagates, handlers = _DRAKE.level, _DRAKE.propagate, _DRAKE.handlers
        _DRAKE.setLevel(logging.WARNING)
        _DRAKE.propagate, _DRAKE.handlers = False, [collector]
        try:
            yield
        finally:
            _DRAKE.setLevel(level)
            _DRAKE.propagate, _DRAKE.handlers = propagates, handlers
    warnings += [
        f"{robot}: {_PLACE.sub(r'line \1: ', text)}"
        for text in dict.fromkeys(collector.texts)
        if not _OURS.search(text)
    ]


def visual_only(
    scene_graph: Any, plant: Any, instances: Sequence[ModelInstanceIndex], robot: str
) -> list[str]:
    """Return a warning for every link that is seen and has no collision shape."""
    inspector = scene_graph.model_inspector()
    found: list[str] = []
    for index in (i for instance in instances for i in plant.GetBodyIndices(instance)):
        frame = plant.GetBodyFrameIdIfExists(index)
        if frame is None or inspector.NumGeometriesForFrameWithRole(frame, Role.kProximity):
            continue
        if inspector.NumGeometriesForFrameWithRole(frame, Role.kIllustration):
            name = f"{robot}::{plant.get_body(index).name()}"
            found.append(f"{name} is seen but has no collision shape: it collides with nothing")
    return found
