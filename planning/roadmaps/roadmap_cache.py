"""RoadmapCache: least-recently-used (LRU) cache of roadmaps in memory and, optionally, in files."""

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

type AnyArray = np.ndarray[Any, np.dtype[Any]]

_STATE_DTYPE, _ROW_DTYPE = "<f8", "<i4"


@runtime_checkable
class RoadmapStore(Protocol):
    """Interface of a roadmap cache: lookup by key before a plan, storage after a construction."""

    def get(self, key: str) -> Roadmap | None:
        """Return the roadmap of that key; None if it is not stored."""
        ...

    def put(self, roadmap: Roadmap) -> None:
        """Store a roadmap; a failure to store is no error."""
        ...


class RoadmapCache:
    """Cache of the most recently used roadmaps, by `Roadmap.key`.

    A cache hit changes no result: a cached roadmap equals the one that would be built. Files are
    written atomically, several processes may share a folder, and a damaged file counts as a miss.
    """

    def __init__(
        self,
        roadmaps: Iterable[Roadmap] = (),
        *,
        folder: Path | None = None,
        max_bytes: int = 2**27,
        max_bytes_on_disk: int = 2**29,
    ) -> None:
        """Create a cache.

        Args:
            roadmaps: Initial content in memory.
            folder: Folder of the cache files, which outlive the process; None for memory only.
            max_bytes: Limit of all arrays in memory [bytes]; the most recently used roadmap stays
                whatever its size.
            max_bytes_on_disk: Limit of all files [bytes]; least recently read files go first.
        """
        self._folder = folder
        self._max_bytes = max_bytes
        self._max_bytes_on_disk = max_bytes_on_disk
        self._roadmaps: OrderedDict[str, Roadmap] = OrderedDict()
        for roadmap in roadmaps:
            self._insert(roadmap)

    def get(self, key: str) -> Roadmap | None:
        """Return the roadmap of that key, from memory or from its file; None if it is in neither.

        Args:
            key: `Roadmap.key`.
        """
        roadmap = self._roadmaps.get(key) or self._read_file(key)
        if roadmap is not None:
            self._insert(roadmap)
        return roadmap

    def put(self, roadmap: Roadmap) -> None:
        """Store a roadmap in memory and in its file; errors of the file system are ignored."""
        self._insert(roadmap)
        if self._folder is not None:
            with suppress(OSError):
                write_atomically(
                    self._path_of(self._folder, roadmap.key), json.dumps(_to_document(roadmap))
                )
                evict_oldest(self._folder, self._max_bytes_on_disk)

    def _insert(self, roadmap: Roadmap) -> None:
        self._roadmaps[roadmap.key] = roadmap
        self._roadmaps.move_to_end(roadmap.key)
        while len(self._roadmaps) > 1 and self._num_bytes > self._max_bytes:
            self._roadmaps.popitem(last=False)

    @property
    def _num_bytes(self) -> int:
        return sum(roadmap.num_bytes for roadmap in self._roadmaps.values())

    def _read_file(self, key: str) -> Roadmap | None:
        if self._folder is None:
            return None
        file = self._path_of(self._folder, key)
        try:
            roadmap = _from_document(json.loads(file.read_text("utf-8")))
            file.touch()
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return None
        return roadmap if roadmap is not None and roadmap.key == key else None

    @staticmethod
    def _path_of(folder: Path, key: str) -> Path:
        return folder / f"{key}.json"


def _to_document(roadmap: Roadmap) -> dict[str, Any]:
    return {
        "key": roadmap.key,
        "digest": roadmap.digest,
        "size": list(roadmap.states.shape),
        "states": _encode(roadmap.states.astype(_STATE_DTYPE)),
        "edges": _encode(roadmap.edges.astype(_ROW_DTYPE)),
        "num_states_checked": roadmap.num_states_checked,
    }


def _from_document(document: dict[str, Any]) -> Roadmap | None:
    """Return the roadmap of a parsed cache file; None if its digest does not match.

    Raises:
        ValueError: A number is malformed, or an array has the wrong length.
        KeyError: A field is missing.
        TypeError: A field has the wrong type.
    """
    roadmap = Roadmap(
        document["key"],
        _decode(document["states"], _STATE_DTYPE).astype(np.float64).reshape(document["size"]),
        _decode(document["edges"], _ROW_DTYPE).astype(np.int32).reshape(-1, 2),
        document["num_states_checked"],
    )
    return roadmap if roadmap.digest == document["digest"] else None


def _encode(array: AnyArray) -> str:
    return base64.b64encode(array.tobytes()).decode("ascii")


def _decode(text: str, dtype: str) -> AnyArray:
    return np.frombuffer(base64.b64decode(text, validate=True), dtype=dtype)
