"""RoadmapCache: roadmaps that were built, kept in memory and, if wanted, in files."""

import base64
import json
from collections import OrderedDict
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np

from planning.domain.planner.roadmap import Roadmap
from planning.parallel.atomic_files import evict_oldest, write_atomically

type Array = np.ndarray[Any, np.dtype[Any]]

_STATE, _ROW = "<f8", "<i4"


@runtime_checkable
class RoadmapStore(Protocol):
    """Where plans look for roadmaps, and leave those that they had to build."""

    def get(self, key: str) -> Roadmap | None:
        """Return the roadmap of that key, if it is there."""
        ...

    def put(self, roadmap: Roadmap) -> None:
        """Keep a roadmap; what does not work out is no error."""
        ...


class RoadmapCache:
    """Keeps the roadmaps that were used last, by their keys.

    Whether a roadmap was here changes no answer: it is what would be built. Files are written in
    one step, several processes may share a folder, and a file that is not what was written is as
    good as none.
    """

    def __init__(
        self,
        roadmaps: Iterable[Roadmap] = (),
        *,
        folder: Path | None = None,
        most_bytes: int = 2**27,
        most_bytes_on_disk: int = 2**29,
    ) -> None:
        """Begin with some roadmaps.

        Args:
            roadmaps: In memory from the start.
            folder: Of files, which outlive the process; None for none.
            most_bytes: Of arrays in memory; the last one is kept whatever its size.
            most_bytes_on_disk: Of files; those that were not read for longest go first.
        """
        self._folder = folder
        self._most_bytes = most_bytes
        self._most_bytes_on_disk = most_bytes_on_disk
        self._kept: OrderedDict[str, Roadmap] = OrderedDict()
        for roadmap in roadmaps:
            self._keep(roadmap)

    def get(self, key: str) -> Roadmap | None:
        """Return the roadmap of that key, from memory or from its file; None if it is in neither.

        Args:
            key: As `Roadmap.key`.
        """
        found = self._kept.get(key) or self._read(key)
        if found is not None:
            self._keep(found)
        return found

    def put(self, roadmap: Roadmap) -> None:
        """Keep a roadmap, in its file too; a full disk is no reason to fail."""
        self._keep(roadmap)
        if self._folder is not None:
            with suppress(OSError):
                write_atomically(self._file(self._folder, roadmap.key), json.dumps(_plain(roadmap)))
                evict_oldest(self._folder, self._most_bytes_on_disk)

    def _keep(self, roadmap: Roadmap) -> None:
        self._kept[roadmap.key] = roadmap
        self._kept.move_to_end(roadmap.key)
        while len(self._kept) > 1 and self._num_bytes > self._most_bytes:
            self._kept.popitem(last=False)

    @property
    def _num_bytes(self) -> int:
        return sum(roadmap.num_bytes for roadmap in self._kept.values())

    def _read(self, key: str) -> Roadmap | None:
        if self._folder is None:
            return None
        file = self._file(self._folder, key)
        try:
            found = _roadmap(json.loads(file.read_text("utf-8")))
            file.touch()
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return None
        return found if found is not None and found.key == key else None

    @staticmethod
    def _file(folder: Path, key: str) -> Path:
        return folder / f"{key}.json"


def _plain(roadmap: Roadmap) -> dict[str, Any]:
    return {
        "key": roadmap.key,
        "digest": roadmap.digest,
        "size": list(roadmap.states.shape),
        "states": _text(roadmap.states.astype(_STATE)),
        "edges": _text(roadmap.edges.astype(_ROW)),
        "num_states_checked": roadmap.num_states_checked,
    }


def _roadmap(document: dict[str, Any]) -> Roadmap | None:
    """Return what was written; None if it is something else.

    Raises:
        ValueError: A number is none, or there are too few or too many.
        KeyError: Something is missing.
        TypeError: Something is of the wrong kind.
    """
    found = Roadmap(
        document["key"],
        _array(document["states"], _STATE).astype(np.float64).reshape(document["size"]),
        _array(document["edges"], _ROW).astype(np.int32).reshape(-1, 2),
        document["num_states_checked"],
    )
    return found if found.digest == document["digest"] else None


def _text(array: Array) -> str:
    return base64.b64encode(array.tobytes()).decode("ascii")


def _array(text: str, kind: str) -> Array:
    return np.frombuffer(base64.b64decode(text, validate=True), dtype=kind)
